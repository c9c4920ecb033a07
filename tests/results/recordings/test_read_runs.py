"""Recordings below a folder: which training each evaluation belongs to, and what does not belong there."""

from pathlib import Path

import pytest

from harness.errors import UsageError
from harness.results.recordings.read_runs import read_all, read_runs
from tests.results.recordings.conftest import PAYS, record


def evaluated(folder: Path, acted: str, after: int) -> Path:
    """A training by each reward, and one evaluation of both policies."""
    for reward in PAYS:
        record(folder / reward, reward, 0, [0.1, 0.2, 0.3])
        record(folder / reward / "evaluation", reward, 0, [0.5] * 3, evaluation=True, acted=acted, after=after)
    return folder


@pytest.mark.parametrize("after", [1, 2, 1000])
def test_an_evaluation_during_the_training_is_no_final_one(tmp_path: Path, after: int):
    """However early it was: after one step too."""
    run = read_runs(evaluated(tmp_path, "deterministic", after)).members["plain", 0]
    assert (run.evaluation, run.other) == (None, None)
    assert [it.facts.after for it in run.before] == [after]


@pytest.mark.parametrize("acted", ["deterministic", "stochastic"])
def test_one_manner_alone_decides(tmp_path: Path, acted: str):
    """Where the policy was evaluated in no other."""
    run = read_runs(evaluated(tmp_path, acted, 0)).members["plain", 0]
    assert run.evaluation is not None
    assert run.evaluation.facts.acted == acted
    assert run.other is None


def test_an_experiment_among_recordings_is_named(tmp_path: Path):
    """Whatever reads all of them refuses it, the audit too."""
    record(tmp_path / "loose", "plain", 0, [0.1])
    (tmp_path / "theirs").mkdir()
    (tmp_path / "theirs" / "plan.json").touch()
    with pytest.raises(UsageError, match=r"holds whole experiments, not only recorded trainings: '.*theirs'"):
        read_all(tmp_path)


def test_an_experiment_itself_is_read(tmp_path: Path):
    """Its own plan lies in the folder, not below it."""
    record(tmp_path / "cells" / "one", "plain", 0, [0.1])
    (tmp_path / "plan.json").touch()
    runs, damaged = read_all(tmp_path)
    assert (len(runs), damaged) == (1, [])
