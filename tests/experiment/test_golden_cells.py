"""Cells whose ids, rows and evaluations were recorded once: how the code is cut must change none of their bits.

``golden_cells.json`` was written by ``python -m tests.experiment.test_golden_cells``.
"""

import json
import sys
import tempfile
from collections.abc import Callable
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from harness.executor import CellOptions
from harness.experiment.plan import check_experiment, expand
from harness.experiment.run_cell import run_cell
from harness.log import Log
from harness.record.cell import Cell
from harness.record.folder import EVALUATIONS, partial_folder
from harness.record.recording.recorded_training import read_recording
from harness.record.trace import read_trace
from harness.registry.registry import load_registry

GOLDEN = Path(__file__).parent / "golden_cells.json"
SMALL = "net_arch=8x8,learning_starts=40,batch_size=8"
ASKED: dict[str, dict[str, Any]] = {
    "kinematic": {"sim": "kinematic", "algo": f"sac-fast:{SMALL}", "reward": "arp", "task": "fd100-reach:horizon=25"},
    "mujoco": {"sim": "mujoco", "algo": "random:num_envs=2", "reward": "dense", "task": "fd100-reach:horizon=25"},
    "environment": {"algo": f"sac-fast:{SMALL}", "task": "gymnasium:id=Pendulum-v1"},
    "envs": {"algo": "random:num_envs=3", "task": "gymnasium:id=CartPole-v1"},
}
COMMON = {"seeds": 1, "steps": 120, "evaluation_episodes": 2, "evaluate_every": 60}
KILLED_AFTER, EVERY = 100, 50


def _cell(name: str) -> Cell:
    """The last cell of an experiment: under the proposed reward, where there is one."""
    return expand(check_experiment({**COMMON, **ASKED[name]}), load_registry()).cells[-1]


def _digest(log: Log) -> str:
    """SHA-256 of all numbers in a log."""
    digest = sha256()
    for name in sorted(log.columns):
        values = np.asarray(log.load()[name])
        if values.dtype.kind in "fiub":
            digest.update(f"{name} {values.dtype} {values.shape}".encode())
            digest.update(np.ascontiguousarray(values).tobytes())
    return digest.hexdigest()


def _digests(folder: Path) -> dict[str, str]:
    """The digest of each recording of a cell: its training, and evaluations in the middle and at the end."""
    found = {}
    for path in sorted((*folder.iterdir(), *folder.glob(f"{EVALUATIONS}/*"))):
        if path.suffix == ".parquet":
            found[path.relative_to(folder).as_posix()] = _digest(read_trace(path))
        elif list(path.glob("recording-*.json")):
            found[path.relative_to(folder).as_posix()] = _digest(read_recording(path))
    return found


def _arithmetic() -> str:
    """What decides the bits of results: versions, and what this machine's functions and sums come to."""
    numbers = np.linspace(-3.0, 3.0, 64 * 64).reshape(64, 64)
    digest = sha256()
    for values in (numbers, numbers.astype(np.float32)):
        for told in (values @ values.T, np.tanh(values), np.sin(values), np.exp(values), values.sum(axis=0)):
            digest.update(told.tobytes())
    versions = " ".join(version(name) for name in ("numpy", "gymnasium", "mujoco"))
    return f"{versions} {sys.platform} {digest.hexdigest()[:16]}"


@pytest.fixture(scope="module")
def golden() -> dict[str, Any]:
    """What was recorded, if numbers are computed here as they were then."""
    recorded: dict[str, Any] = json.loads(GOLDEN.read_text())
    if recorded["arithmetic"] != _arithmetic():
        pytest.skip(f"recorded with {recorded['arithmetic']}, here it is {_arithmetic()}")
    return recorded["cells"]


@pytest.mark.parametrize("name", ASKED)
def test_ids_stay(name: str):
    """On every machine: folders of earlier versions go on."""
    assert _cell(name).id == json.loads(GOLDEN.read_text())["cells"][name]["id"]


@pytest.mark.parametrize("name", ASKED)
def test_rows_and_evaluations_stay(name: str, golden: dict[str, Any], tmp_path: Path):
    """Training, evaluations in the middle, in both manners and of random actions: bit for bit."""
    assert run_cell(_cell(name), tmp_path / "cell", lambda word: None).status == "done"
    assert _digests(tmp_path / "cell") == golden[name]["digests"]


@pytest.mark.parametrize("name", ASKED)
def test_a_killed_training_goes_on_to_the_same_rows(
    name: str, golden: dict[str, Any], tmp_path: Path, train_in_a_process: Callable[..., None]
):
    """An arm's state is restored, an environment is told the same again."""
    folder = tmp_path / "cell"
    train_in_a_process(_cell(name), folder, every=EVERY, until=KILLED_AFTER)
    assert partial_folder(folder).is_dir()
    manifest = run_cell(_cell(name), folder, lambda word: None, CellOptions(checkpoint_every=EVERY))
    assert (manifest.status, manifest.resumed_from > 0) == ("done", True)
    assert _digests(folder) == golden[name]["digests"]


def _record() -> None:
    """Write `GOLDEN` anew; only for what changes numbers on purpose."""
    cells = {}
    for name in ASKED:
        with tempfile.TemporaryDirectory() as folder:
            run_cell(_cell(name), Path(folder) / "cell", lambda word: None)
            cells[name] = {"id": _cell(name).id, "digests": _digests(Path(folder) / "cell")}
    GOLDEN.write_text(json.dumps({"arithmetic": _arithmetic(), "cells": cells}, indent=2) + "\n")


if __name__ == "__main__":
    _record()
