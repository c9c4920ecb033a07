"""Recordings of an env whose every number is known."""

import numpy as np
import pytest

import harness
from tests.recorder.conftest import Counting


@pytest.fixture(autouse=True)
def written_at_once(monkeypatch):
    """Every step is on the disk when it has been taken, and a part is full after 16."""
    monkeypatch.setattr("harness.record.parts.SOONEST", 0.0)
    monkeypatch.setattr("harness.record.parts.LARGEST_SHARE", 1e9)
    for module in ("parts", "recording.recorded_training"):
        monkeypatch.setattr(f"harness.record.{module}.PART_ROWS", 16)


@pytest.fixture
def record(tmp_path):
    """Get an env that records into a folder. Its episodes have three steps, pay 6, half by each term, and succeed."""
    made = []

    def make(name="runs/one", reward="counted", **told):
        rewards = {reward: {"left": "left", "again": "left"}}
        given = {"behaviour": {"success": "final"}, "seed": 0, "pay": True, **told}
        env = harness.RecordRewards(Counting(), tmp_path / name, trained_with=reward, rewards=rewards, **given)
        env.reset(seed=0)
        made.append(env)
        return env

    yield make
    for env in made:
        env.close()


@pytest.fixture
def step():
    """Take steps in an env; an episode that ends is followed by the next."""

    def take(env, count):
        for _ in range(count):
            _, _, terminated, truncated, _ = env.step(np.zeros(1, np.float32))
            if terminated or truncated:
                env.reset()

    return take
