"""Trainings that leave checkpoints, and trainings that go on from one: on the easy task, files included."""

import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from harness.algorithm import Algorithm, needs_goals
from harness.arrays import Float
from harness.authoring.checking import Checkpoint, read_checkpoint, store
from harness.env import ReachVectorEnv
from harness.policy import Policy
from harness.progress import TrainingState

from .trainings import ENV_SEED, Told, WatchedEnv, steps_for

ORIGIN = {"cell": "the easy task"}


@dataclass
class Left:
    """A checkpoint that a training left, alone in a folder of its own, and the rows that were recorded before."""

    folder: Path
    steps: int
    rows: int


@dataclass
class Resumable:
    """A training that was done: the policy, every row that was recorded, the checkpoints that were left.

    Also the scalars that were told, with the steps after which they were.
    """

    policy: Policy
    rows: Float
    left: list[Left]
    scalars: list[tuple[int, dict[str, float]]]


class _Keeping(Told):
    """Writes a checkpoint every so many steps into a folder; may go on from one."""

    def __init__(
        self, env: ReachVectorEnv, rows: list[Float], folder: Path, every: int, start: Checkpoint | None
    ) -> None:
        super().__init__()
        self._env, self._rows, self._folder, self._every, self._start = env, rows, folder, every, start
        self._last = start.steps if start else 0
        self._rings = start.rings if start else {}
        self.left: list[Left] = []
        self.told_scalars: list[tuple[int, dict[str, float]]] = []

    def checkpoint(self, steps: int, make: Callable[[], TrainingState]) -> None:
        if steps < self._last + self._every:
            return
        stored = store(self._folder, make(), self._env.state(), self._rings)
        Checkpoint(steps, ORIGIN, **stored).write(self._folder)
        self._last, self._rings = steps, stored["rings"]
        copied = self._folder.with_name(f"{self._folder.name}-{steps}")
        shutil.copytree(self._folder, copied)
        self.left.append(Left(copied, steps, sum(map(len, self._rows))))

    def scalars(self, steps: int, values: Mapping[str, float]) -> None:
        self.told_scalars.append((steps, dict(values)))

    def restored(self) -> TrainingState | None:
        return self._start.restored(self._folder) if self._start else None


def open_easy(algorithm: Algorithm) -> ReachVectorEnv:
    """The easy task with as many envs as the algorithm wants."""
    return WatchedEnv(algorithm.num_envs, min(algorithm.action_spaces), needs_goals(algorithm))


def train_with_checkpoints(
    algorithm: Algorithm,
    steps: int,
    every: int,
    folder: Path,
    start: Left | None = None,
    open_env: Callable[[Algorithm], ReachVectorEnv] = open_easy,
) -> Resumable:
    """Train; leave a checkpoint every so many steps, or as soon after as the algorithm offers one.

    Args:
        algorithm: What learns.
        steps: Environment steps in all, or a few more to make it a multiple of the algorithm's envs.
        every: Environment steps from one checkpoint to the next, at least.
        folder: Where the checkpoints are left, and beside it.
        start: To go on from.
        open_env: What to train on.
    """
    folder.mkdir(exist_ok=True)
    env, rows = open_env(algorithm), list[Float]()
    env.recorder = _Rows(rows)
    checkpoint = None
    if start is None:
        env.reset(seed=ENV_SEED)
    else:
        shutil.copytree(start.folder, folder, dirs_exist_ok=True)
        checkpoint = read_checkpoint(folder, ORIGIN)
        env.restore(checkpoint.env)
    progress = _Keeping(env, rows, folder, every, checkpoint)
    policy = algorithm.train(env, steps_for(algorithm, steps), 0, progress)
    env.close()
    return Resumable(policy, np.concatenate(rows), progress.left, progress.told_scalars)


class _Rows:
    """A `harness.record.trace.Recorder` that keeps the rows."""

    def __init__(self, rows: list[Float]) -> None:
        self._rows = rows

    def append(self, rows: Float) -> None:
        self._rows.append(rows.copy())


def differences(whole: Resumable, again: Resumable, left: Left | None = None) -> str:
    """How a training that went on from `left`, or from the beginning, ended otherwise; empty if it did not."""
    if not np.array_equal(again.rows, whole.rows[left.rows if left else 0 :]):
        return "does other steps"
    same = all(np.array_equal(again.policy.weights[name], array) for name, array in whole.policy.weights.items())
    return "" if same else "ends with other weights"
