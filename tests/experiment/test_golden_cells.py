"""Cells whose ids, rows and evaluations were recorded once: how the code is cut must change none of their bits.

Where a machine computes other bits, the first rows are compared.
``golden_cells.json`` was written by ``python -m tests.experiment.test_golden_cells``.
"""

import json
import tempfile
from functools import cache
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harness.executor import CellOptions
from harness.experiment.plan import check_experiment, expand
from harness.experiment.run_cell import run_cell
from harness.record import partial_folder, read_recording, read_trace
from tests.arithmetic import arithmetic
from tests.registered import REGISTRY

FILE = Path(__file__).parent / "golden_cells.json"
GOLDEN = json.loads(FILE.read_text())
ROWS, COLUMNS = 50, ("action", "qpos", "distance", "reward", "reward/own")
SMALL = "net_arch=8x8,learning_starts=40,batch_size=8"
ASKED = {
    "kinematic": {"sim": "kinematic", "algo": f"sac-fast:{SMALL}", "reward": "arp", "task": "fd100-reach:horizon=25"},
    "mujoco": {"sim": "mujoco", "algo": "random:num_envs=2", "reward": "dense", "task": "fd100-reach:horizon=25"},
    "environment": {"algo": f"sac-fast:{SMALL}", "task": "gymnasium:id=Pendulum-v1"},
    "envs": {"algo": "random:num_envs=3", "task": "gymnasium:id=CartPole-v1"},
}
COMMON = {"seeds": 1, "steps": 120, "evaluation_episodes": 2, "evaluate_every": 60}
KILLED_AFTER, EVERY = 100, 50


def _cell(name):
    """The last cell of an experiment: under the proposed reward, where there is one."""
    return expand(check_experiment({**COMMON, **ASKED[name]}), REGISTRY).cells[-1]


def _told(folder):
    """Each recording of a cell: its training, and evaluations in the middle and at the end."""
    found = {}
    for path in sorted((*folder.iterdir(), *folder.glob("evaluations/*"))):
        if path.suffix == ".parquet":
            found[path.relative_to(folder).as_posix()] = read_trace(path).load()
        elif list(path.glob("recording-*.json")):
            found[path.relative_to(folder).as_posix()] = read_recording(path).load()
    return found


def _digest(log):
    """SHA-256 of all numbers in a log."""
    digest = sha256()
    for name in sorted(log.columns):
        values = np.asarray(log[name])
        if values.dtype.kind in "fiub":
            digest.update(f"{name} {values.dtype} {values.shape}".encode())
            digest.update(np.ascontiguousarray(values).tobytes())
    return digest.hexdigest()


def _digests(folder):
    return {name: _digest(log) for name, log in _told(folder).items()}


def _first_rows(folder):
    """What was done and paid at the first steps of the training."""
    told = _told(folder)
    log = next(told[name] for name in ("trace.parquet", "training") if name in told)
    return np.concatenate([log[name][:ROWS].reshape(ROWS, -1) for name in COLUMNS if name in log.columns], axis=1)


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    """The folder of a cell that was done here without a break."""

    @cache
    def train(name):
        folder = tmp_path_factory.mktemp(name) / "cell"
        assert run_cell(_cell(name), folder, lambda word: None).status == "done"
        return folder

    return train


@pytest.mark.parametrize("name", ASKED)
def test_ids_stay(name):
    """Folders of earlier versions go on."""
    assert _cell(name).id == GOLDEN["cells"][name]["id"]


@pytest.mark.parametrize("name", ASKED)
def test_rows_and_evaluations_stay(name, trained):
    """The first rows, those of a learner that learns among them, to rounding; all in bits where operations are.

    All: training, evaluations in the middle, in both manners and of random actions.
    """
    golden = GOLDEN["cells"][name]
    rows = np.array([line.split() for line in golden["rows"]], float)
    assert_allclose(_first_rows(trained(name)), rows, rtol=0.0, atol=1e-6)
    if GOLDEN["arithmetic"] == arithmetic():
        assert _digests(trained(name)) == golden["digests"]


@pytest.mark.parametrize("name", ASKED)
def test_a_killed_training_goes_on_to_the_same_rows(name, trained, tmp_path, train_in_a_process):
    """Bit for bit those of one without a break: an arm's state is restored, an environment is told the same again."""
    folder = tmp_path / "cell"
    train_in_a_process(_cell(name), folder, every=EVERY, until=KILLED_AFTER)
    assert partial_folder(folder).is_dir()
    manifest = run_cell(_cell(name), folder, lambda word: None, CellOptions(checkpoint_every=EVERY))
    assert (manifest.status, manifest.resumed_from > 0) == ("done", True)
    assert _digests(folder) == _digests(trained(name))


def _record():
    """Write `GOLDEN` anew; only for what changes numbers on purpose."""
    cells = {}
    for name in ASKED:
        with tempfile.TemporaryDirectory() as temporary:
            folder = Path(temporary) / "cell"
            run_cell(_cell(name), folder, lambda word: None)
            rows = [" ".join(f"{number:.7f}" for number in row) for row in _first_rows(folder)]
            cells[name] = {"id": _cell(name).id, "digests": _digests(folder), "rows": rows}
    FILE.write_text(json.dumps({"arithmetic": arithmetic(), "cells": cells}, indent=2) + "\n")


if __name__ == "__main__":
    _record()
