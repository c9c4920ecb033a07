"""Experiments' folders that version 0.2.0 left, of an arm and of an environment, mean what they meant.

They were made by that version with::

    harness run --sim kinematic --algo sac:net_arch=8x8,learning_starts=50 --reward arp --seeds 2
        --task fd100-reach:horizon=25 --steps 120 --evaluation-episodes 2 --out arm
    harness run --task gymnasium:id=Pendulum-v1 --algo sac-fast:net_arch=8x8,learning_starts=50 --reward own,own
        --seeds 2 --steps 300 --evaluation-episodes 2 --evaluate-every 150 --out env

``arm.json`` and ``env.json`` are taken from what its ``harness report --json`` said. What it derived is left out.
"""

import json
import shutil
from pathlib import Path

import pytest

from harness.cli import main
from harness.experiment.experiment import prepare
from harness.experiment.plan import read_experiment
from harness.experiment.run_options import RunOptions
from harness.record.cell import read_manifest
from harness.record.store import EXPERIMENT, Store

LEFT = Path(__file__).parent / "v0.2.0"
FOLDERS = ("arm", "env")
CELLS = sorted(path.relative_to(LEFT).as_posix() for path in LEFT.glob("*/cells/*"))


@pytest.fixture
def left(tmp_path):
    """A copy of the folders, to be written into."""
    return Path(shutil.copytree(LEFT, tmp_path / "left"))


def _said(folder, capsys):
    """What ``harness report --json`` says of the one comparison, cut as the files beside the folders are."""
    with pytest.raises(SystemExit) as stopped:
        main(["report", str(folder), "--json"])
    assert not stopped.value.code
    [it] = json.loads(capsys.readouterr().out)["combinations"]
    parts = ("eta", "ruler", "behaviour")
    return {
        "seeds": it["seeds"],
        "total": {name: part["value"] for name, part in it["total"].items()},
        "baseline_index": it["baseline_index"],
        "proposed_index": it["proposed_index"],
        **{name: {part: it[name][part]["value"] for part in parts} for name in ("eta_N", "eta_P")},
        "behaviour": {
            f"{one['manner']}/{one['name']}": [one[who] for who in ("baseline", "proposed", "random")]
            for one in it["behaviour"]
        },
    }  # fmt: skip


def _flat(data, path=""):
    """Every number of plain data, by where it stands."""
    if isinstance(data, dict):
        return {key: value for name, part in data.items() for key, value in _flat(part, f"{path}/{name}").items()}
    if isinstance(data, list):
        return _flat(dict(enumerate(data)), path)
    return {path: data}


def require_numbers(folder, before, capsys):
    """A report of a folder has the numbers that it had; later measures come beside them."""
    found, before = _flat(_said(folder, capsys)), _flat(before)
    assert before.keys() <= found.keys()
    for path, value in before.items():
        assert found[path] == (value if value is None else pytest.approx(value, rel=1e-9, abs=1e-12)), path


@pytest.mark.parametrize("name", FOLDERS)
def test_numbers_are_those_that_were_told(name, left, capsys):
    """Indices, etas with both of their parts, sums and means of all measures."""
    require_numbers(left / name, json.loads((LEFT / f"{name}.json").read_text()), capsys)


@pytest.mark.parametrize("path", CELLS)
def test_cell_has_the_id_that_it_had(path):
    """The hash of its content is the name of its folder."""
    assert read_manifest(LEFT / path).cell.id == Path(path).name


def resumed(folder, changed="keep"):
    """The algorithms of the plan's cells, and what happens when the folder's own experiment file is run in it."""
    events = []
    run = prepare(read_experiment(folder / EXPERIMENT, {}), RunOptions(out=folder, jobs=1, changed=changed))
    run.run(events.append)
    return [cell.algorithm.name for cell in run.plan.cells], events


def test_nothing_of_an_environment_is_run_again(left):
    """The same experiment finds all of its cells done."""
    _, events = resumed(left / "env")
    assert events == []


def test_missing_cell_of_an_environment_is_done_again(left):
    """One cell, and the folder is whole again."""
    cell = Store.open(left / "env").read_plan().cells[1]
    folder = Store.open(left / "env").cell_folder(cell)
    shutil.rmtree(folder)
    _, events = resumed(left / "env")
    assert {event.cell for event in events} == {cell}
    assert read_manifest(folder).status == "done"


def test_cells_of_then_never_meet_those_that_sac_means_now(left):
    """``sac`` meant stable-baselines3's algorithm in 0.2: its four cells stay, and four others are trained."""
    before = {path.name for path in (left / "arm" / "cells").iterdir()}
    learners, events = resumed(left / "arm")
    trained = {event.cell.id for event in events}
    assert set(learners) == {"sac-fast"}
    assert len(trained) == len(before) == 4
    assert not trained & before
