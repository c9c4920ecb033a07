"""What checkpoints take of a training."""

import hashlib
import os
import statistics
import time
from typing import Any

import numpy as np
import pytest
from numpy.random import default_rng

import harness
from harness import load_registry
from harness.algorithm import Progress, Ring, TrainingState
from harness.env.vector_env import build_world
from harness.experiment.checkpoints.checkpoint import Checkpoint, read_checkpoint, store
from harness.experiment.plan import Experiment, expand
from harness.experiment.run_cell import SECONDS
from tests.bench.timings.conftest import cpu_seconds

pytestmark = pytest.mark.bench
FIRST, NEXT, MOST_SHARE = 0.15, 0.8, 0.02
"""Of the speed of copying all transitions to a file, with a SHA-256; and of ten minutes."""
ORIGIN = {"cell": "timed"}


class Standing(Progress):
    """Keeps the state of a training in its middle."""

    def __init__(self, env: Any, after: int) -> None:
        self._env, self._after = env, after
        self.kept: list[tuple[TrainingState, TrainingState]] = []

    def checkpoint(self, steps, make):
        """Once."""
        if steps >= self._after and not self.kept:
            self.kept.append((make(), self._env.state()))


def _standing(algorithm, steps):
    """What a training and its env hold after half of so many steps."""
    registry = load_registry()
    cell = expand(Experiment(sim=["mujoco"], algo=[algorithm], reward=["arp"], steps=4_800), registry).cells[0]
    robot, built = harness.load_robot("fd100", registry), cell.algorithm.build(registry, "algorithms")
    env = build_world(cell, robot, registry).open(built.num_envs, resumable=True)
    env.reset(seed=0)
    standing = Standing(env, steps // 2)
    built.train(env, steps, 0, standing)
    env.close()
    return standing.kept[0]


def _full(ring, rows):
    """A ring of so many places, all of which were written."""
    rng = default_rng(0)
    columns = {
        name: rng.standard_normal((rows, *array.shape[1:]), np.float32).astype(array.dtype)
        for name, array in ring.columns.items()
    }
    return Ring(columns, rows)


def _copy(ring, path):
    """The bytes of a ring into one file, with their SHA-256."""
    digest = hashlib.sha256()
    with path.open("wb") as file:
        for column in ring.columns.values():
            digest.update(column)
            file.write(column)
        os.fsync(file.fileno())


@pytest.mark.parametrize("algorithm", [pytest.param("sb3-sac", id="sac"), "sac-fast"])
def test_a_checkpoint_of_a_full_buffer_beside_a_copy(tmp_path, require_ratio, amount, algorithm):
    """The first one writes all transitions, a later one what is new: a tenth. Read again it is the same."""
    state, env = _standing(algorithm, 160)
    (name,) = (name for name, value in state.items() if isinstance(value, Ring))
    full, rings = _full(state[name], amount(1_000_000, 1_000)), {}
    rows = len(full.columns[min(full.columns)])
    copying = statistics.median(cpu_seconds(lambda: _copy(full, tmp_path / "copy")) for _ in range(3))
    for which, written, at_least in (("first", rows, FIRST), ("next", rows + rows // 10, NEXT)):
        begin = time.process_time()
        stored = store(tmp_path, {**state, name: Ring(full.columns, written)}, env, rings)
        Checkpoint(7, ORIGIN, **stored).write(tmp_path)
        spent, rings = time.process_time() - begin, stored["rings"]
        require_ratio(copying / spent, at_least, f"({rows:,} transitions: {spent:.2f} s)", which)
        back = read_checkpoint(tmp_path, ORIGIN).restored(tmp_path)[name]
        assert all(np.array_equal(back.columns[column], array) for column, array in full.columns.items())


@pytest.mark.parametrize("algorithm", ["sb3-sac", "sac-fast", "td3", "ppo", "spg", "dqn", "ddqn", "random", "ik"])
def test_a_checkpoint_takes_two_hundredths_of_a_training_at_most(tmp_path, is_timed, amount, algorithm):
    """One every ten minutes of training; up to 0.006 % of them were measured."""
    state, env = _standing(algorithm, amount(1_600, 160))
    begin = time.process_time()
    Checkpoint(7, ORIGIN, **store(tmp_path, state, env, {})).write(tmp_path)
    share = (time.process_time() - begin) / SECONDS
    print(f"\n  {algorithm}: {100 * share:.4f} % of ten minutes")  # noqa: T201
    assert not is_timed or share <= MOST_SHARE
