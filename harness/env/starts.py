"""Where the episodes of a batch start, and what their targets are."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from harness.arrays import Float, Mask
from harness.env.episodes import Episodes
from harness.env.random_streams import TRIES, Seed, Streams
from harness.env.surroundings import Surroundings
from harness.errors import UsageError
from harness.robot import Robot
from harness.simulator import State
from harness.task import Task


class Starts:
    """Draws starts and targets, and writes them down.

    Attributes:
        waiting: Whether episodes have begun whose first step has not followed yet.
    """

    def __init__(self, task: Task, robot: Robot, episodes: Episodes, around: Surroundings | None) -> None:
        self._task, self._robot, self._episodes, self._around = task, robot, episodes, around
        self._fresh = np.zeros(len(episodes.matrix), bool)  # where it has not
        self.waiting = False
        self.seed(None)

    def seed(self, seed: Seed) -> None:
        """Begin the streams of all envs anew, from one seed or one per env; None: from chance."""
        self._streams = Streams(self._task, self._robot, len(self._fresh), seed)
        if seed is not None and self._around:
            self._around.seed(seed)

    def draw(self, mask: Mask, qpos: Float) -> Float:
        """Joint positions to start at in the envs of `mask`, those of `qpos` in the others; a new array."""
        starts = qpos.copy()
        for k in np.flatnonzero(mask).tolist():
            starts[k] = self._streams.start(k)
        if self._around:
            self._around.draw(mask)
        return starts

    def begin(self, mask: Mask, state: State) -> None:
        """Begin episodes in the envs of `mask`, whose arms were put where `state` says."""
        episodes = self._episodes
        target, numbers = episodes.target.copy(), episodes.numbers.copy()
        for k in np.flatnonzero(mask).tolist():
            target[k], numbers[k] = self._first_target(k, state)
        episodes.start(mask, state, target, numbers)
        if self._around:
            self._around.begin(mask)
        # An episode that was left before its first step left no row: its number is free.
        episodes.episode[mask & ~self._fresh] += 1.0
        self._fresh |= mask
        self.waiting = True

    def set_next(self, mask: Mask) -> None:
        """Give the envs of `mask`, which reached their targets, the next ones."""
        episodes = self._episodes
        target, numbers = episodes.target.copy(), episodes.numbers.copy()
        for k in np.flatnonzero(mask):
            target[k], numbers[k] = self._streams.target(int(k), episodes.end_effector[k])
        episodes.set_target(mask, target, numbers)

    def take_rows(self) -> Float:
        """The rows to record of the episodes that wait, which do so no more; a new array.

        It is asked for when the first step follows: an episode without a step leaves no trace.
        """
        rows = self._episodes.record[self._fresh]
        rows[:, self._episodes.columns("action")] = 0.0
        self._fresh[:] = False
        self.waiting = False
        return rows

    def state(self) -> dict[str, Any]:
        """Everything that `restore` needs beside the episodes' matrix."""
        return {"streams": self._streams.pack(), "started": self._fresh.copy(), "starting": self.waiting}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on from `state`, which the method of this name returned."""
        self._streams.unpack(state["streams"])
        self._fresh, self.waiting = state["started"].copy(), bool(state["starting"])

    def _first_target(self, env: int, state: State) -> tuple[Float, Float]:
        """A target, (3,), that the arm is not at, and the numbers of a goal.

        One that it can reach, where the arm is not as drawn.
        """
        for _ in range(TRIES):
            target, numbers = self._streams.target_apart(env, state.end_effector[env], state.qpos[env])
            if self._around is None or self._around.is_reached(env, target, state.qpos[env]):
                return target, numbers
        raise UsageError("length_variation is too large: a shorter arm reaches almost no target. Choose a smaller one")
