"""The folder of a recorded training: what is written is read, and what is damaged is named."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from harness.record.recording.facts import Failure, Source, TrainingFacts
from harness.record.recording.recorded_training import (
    RecordedTraining,
    read_recording,
)
from harness.record.recording.recording_writer import write_recording

FACTS = TrainingFacts(
    rewards=("v1", "v2"),
    trained_with="v2",
    behaviour=("success",),
    num_envs=2,
    seed=7,
    env={"id": "Some-v0", "kwargs": {"gravity": 9.81}},
    versions={"gymnasium": "1.2"},
    sources={"reward_v1": Source("a" * 64, "def v1(): ..."), "reward_v2": Source("", "what the env pays")},
    failures=(Failure("reward_v1", env=1, episode=3, step=0, reason="ValueError: no"),),
)


def _training(calls: int, facts: TrainingFacts = FACTS) -> RecordedTraining:
    """Two envs, episodes of five steps."""
    time = np.repeat(np.arange(calls), 2)
    numbers = np.random.default_rng(0).normal(size=(3, len(time)))
    return RecordedTraining(
        facts=facts,
        time=time,
        env=np.tile(np.arange(2, dtype=np.int32), calls),
        episode=(time // 5).astype(np.int32),
        step=(time % 5).astype(np.int32),
        rewards={"v1": numbers[0], "v2": numbers[1]},
        behaviour={"success": numbers[2]},
        terminated=time % 5 == 4,
        truncated=np.zeros(len(time), bool),
    )


@pytest.fixture
def small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Parts of seven steps."""
    for module in ("recorded_training", "recording_writer"):
        monkeypatch.setattr(f"harness.record.recording.{module}.PART_ROWS", 7)


def _require_same(found: RecordedTraining, expected: RecordedTraining) -> None:
    for name in ("time", "env", "episode", "step", "terminated", "truncated"):
        one, other = getattr(found, name), getattr(expected, name)
        assert one.dtype == other.dtype
        assert np.array_equal(one, other), name
    for one, other in ((found.rewards, expected.rewards), (found.behaviour, expected.behaviour)):
        assert list(one) == list(other)
        assert all(np.array_equal(one[name], other[name], equal_nan=True) for name in one)


@pytest.mark.parametrize("calls", [0, 3, 7, 20])
@pytest.mark.usefixtures("small_parts")
def test_what_is_written_is_read(tmp_path: Path, calls: int):
    """To the last bit, whether parts are full or not; and the facts."""
    write_recording(tmp_path / "run", _training(calls))
    found = read_recording(tmp_path / "run")
    _require_same(found, _training(calls))
    assert found.facts == replace(FACTS, closed=True)
    assert len(found) == 2 * calls
    assert len(list((tmp_path / "run").glob("steps-0-*.parquet"))) == -(-2 * calls // 7)
