"""A trace of many parts is read as one of one part, at every door."""

import json

import numpy as np
import pytest

import harness as package
from harness.record import TRACE, read_trace
from harness_plugins.watch.recorded import Trace


@pytest.fixture
def folders(toys, tmp_path, monkeypatch):
    """The same experiment, its traces in one part and in many."""
    given = {"sim": "ideal", "algo": "wander", "reward": "arp", "task": "fd100-reach:horizon=5", "seeds": 2}
    for name in ("one", "many"):
        package.run(**given, steps=60, evaluation_episodes=2, executor="here", out=tmp_path / name)
        for module in ("parts", "trace"):
            monkeypatch.setattr(f"harness.record.{module}.PART_ROWS", 16)
    return tmp_path / "one", tmp_path / "many"


def _cells(folder):
    return sorted((folder / "cells").glob("[!.]*"))


def test_columns_are_the_same(folders):
    """Of every cell, row by row; there are many parts of the training, and one of an evaluation."""
    for one, many in zip(*map(_cells, folders), strict=True):
        assert [len([*many.glob(f"{name}*.parquet")]) for name in ("trace", "evaluation")] == [5, 1]
        traces = [read_trace(it / TRACE) for it in (one, many)]
        for name in traces[0].names:
            np.testing.assert_array_equal(traces[0][name], traces[1][name])


def _report(harness, folder):
    told = json.loads(harness("report", folder, "--json").out)
    for cell in told["cells"]:
        for name in [it for it in cell if it.endswith("seconds") or it in ("started", "peak_memory")]:
            del cell[name]
    return json.dumps(told, indent=1).replace(str(folder), "").splitlines()


def _export(harness, folder):
    assert harness("export", folder, "--csv", "--out", folder / "csv").status == 0
    return [it.read_bytes() for it in sorted((folder / "csv").rglob("*.csv"))]


DOORS = {
    "report": _report,
    "export": _export,
    "score": lambda harness, folder: harness("score", folder, "--reward", "dense", "--json").out.replace(
        str(folder), ""
    ),
    "verify": lambda harness, folder: harness("verify", folder).status,
    "live page": lambda harness, folder: [_blocks(cell / TRACE) for cell in _cells(folder)],
}


def _blocks(path):
    trace = Trace(path)
    trace.look(0)
    blocks = trace.blocks
    return blocks.means.tolist(), blocks.steps.tolist()


@pytest.mark.parametrize("door", DOORS)
def test_every_door_says_the_same(harness, folders, door):
    """Numbers and words."""
    one, many = (DOORS[door](harness, folder) for folder in folders)
    assert one == many


def test_a_later_part_that_is_another_is_noticed(harness, folders, tmp_path):
    """By verify, by merge, and among trainings that are equal bit for bit."""
    _, many = folders
    cell = _cells(many)[0]
    assert harness("merge", many, folders[0], "--out", tmp_path / "merged").status != 0  # other files
    (cell / "trace-00002.parquet").unlink()
    assert "trace-00002.parquet is missing" in str(harness("verify", many))
