"""Folders that version 0.3.0 left mean what they meant: an arm's, an environment's, a killed run's and a recording's.

``v0.3.0.zip`` was made by that version with OpenBLAS's kernel for Haswell and::

    harness run --sim kinematic --algo sac:net_arch=8x8,learning_starts=50 --reward arp --seeds 2
        --task fd100-reach:horizon=25 --steps 120 --evaluation-episodes 2 --evaluate-every 60 --out arm
    harness run --task gymnasium:id=Pendulum-v1 --algo sac:net_arch=8x8,learning_starts=50 --reward own,own
        --seeds 2 --steps 300 --evaluation-episodes 2 --evaluate-every 150 --out env
    harness run --sim kinematic --algo ppo:net_arch=8,rollout=64,num_envs=1 --reward dense --seeds 1
        --task fd100-reach:horizon=25 --steps 2000 --checkpoint-every 128 --evaluation-episodes 2 --out killed
    harness audit --task gymnasium:id=Pendulum-v1 --reward own --budget 2000 --out cert

``killed`` was killed after its first checkpoint. ``loose`` has two trainings each by two rewards, recorded by
``harness.RecordRewards``. ``arm.json`` and ``env.json`` are taken from what its ``harness report --json`` said.
"""

import json
import shutil
from pathlib import Path

import pytest

from harness import load_results
from harness.cli import main
from harness.record.cell import read_manifest
from harness.record.store import Store
from tests.compatibility.test_v0_2_0 import FOLDERS, require_numbers, resumed
from tests.refusals import refused


@pytest.fixture
def left(tmp_path):
    """The folders, to be written into."""
    shutil.unpack_archive(Path(__file__).parent / "v0.3.0.zip", tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", FOLDERS)
def test_numbers_are_those_that_were_told(name, left, capsys):
    """Indices, etas with both of their parts, sums and means of all measures."""
    require_numbers(left / name, json.loads((left / f"{name}.json").read_text()), capsys)


@pytest.mark.parametrize("name", FOLDERS)
def test_cells_have_the_ids_that_they_had(name, left):
    """The hash of a cell's content is the name of its folder."""
    folders = list((left / name / "cells").iterdir())
    assert len(folders) == 4
    assert [read_manifest(it).cell.id for it in folders] == [it.name for it in folders]


@pytest.mark.parametrize("name", FOLDERS)
def test_a_missing_cell_alone_is_done_again(name, left):
    """The others are found done."""
    store = Store.open(left / name)
    cell = store.read_plan().cells[1]
    shutil.rmtree(store.cell_folder(cell))
    _, events = resumed(left / name)
    assert {event.cell for event in events} == {cell}
    assert read_manifest(store.cell_folder(cell)).status == "done"


def test_a_killed_training_begins_again_and_says_so(left):
    """Its checkpoint is of an earlier format, and none of its rows is taken for one of today's."""
    resumed(left / "killed")
    store = Store.open(left / "killed")
    first, *_ = store.read_plan().cells
    assert [it.status for it in store.manifests()] == ["done"] * 2
    told = (store.cell_folder(first) / "log.txt").read_text()
    assert "this one started over: checkpoint.safetensors is of no use: it has format 2" in told
    assert not list((left / "killed").rglob("trace.[0-9]*"))


def test_recordings_are_trainings(left):
    """Two by each reward, with the measure that was recorded."""
    (trainings,) = load_results(left / "loose").trainings
    assert sorted(trainings.runs) == [(reward, seed) for reward in ("own", "slow") for seed in (0, 1)]


def test_a_certificate_is_paid_what_it_was(left, capsys):
    """Every step; what else it names is of the version that wrote it."""
    with pytest.raises(SystemExit):
        main(["audit", "--replay", str(left / "certificate.json")])
    assert "-629 in 200 steps" in capsys.readouterr().out


def test_commands_of_then_say_what_makes_them_go_on(left):
    """Files of the built-in plugins changed since."""
    cell = Store.open(left / "arm").read_plan().cells[1]
    shutil.rmtree(Store.open(left / "arm").cell_folder(cell))
    with refused(r"3 done cells were made by another .*--changed keep"):
        resumed(left / "arm", changed="refuse")
