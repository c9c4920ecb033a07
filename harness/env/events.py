"""Ground, obstacle, target, horizon: where the episodes of a batch end, and what the task pays for that."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from harness.arrays import Float, Mask
from harness.conditions import conditions_of
from harness.env.episodes import Episodes
from harness.robot import Robot
from harness.task import Task

GROUND, REACHED, HELD, TERMINATED, TRUNCATED = range(5)
"""Columns of `Episodes.flags`."""


class Events:
    """Looks at every step. It writes flags and event terms into the record if something happened.

    Attributes:
        marked: Whether the record holds flags or event terms of the step before.
    """

    def __init__(self, task: Task, robot: Robot, episodes: Episodes) -> None:
        self._task, self._robot, self._episodes = task, robot, episodes
        # Asked for once: a task may be a dataclass with checks, and these are read in every step.
        self._horizon, self._goes_on = task.horizon, not task.ends_at_target
        self._epsilon = np.array(task.epsilon, float)  # as an array: numpy turns a float into one at every call
        self._inside = np.zeros(len(episodes.matrix), bool)  # where the end effector was in the target one step earlier
        self._until_horizon = 0  # no episode is truncated in so many steps
        self.marked = False

    def begin(self, mask: Mask) -> None:
        """Episodes have begun in the envs of `mask`."""
        self._inside[mask] = False
        self._until_horizon = self._horizon - int(self._episodes.step.max())

    def set_target(self, mask: Mask) -> None:
        """Note new targets in the envs of `mask`. An end effector that is in its target must leave and enter it."""
        self._inside[mask] = self._episodes.distance[mask] <= self._epsilon

    def judge(self, distance: Float, ground: Mask, struck: Mask | None, held: Mask | None) -> tuple[Mask, Mask, Mask]:
        """Where targets are reached, and where episodes are terminated and truncated by this step; (num_envs,) each.

        Args:
            distance: To the targets, [m], or the error of a goal.
            ground: Where arms touched the ground.
            struck: Where they touched an obstacle; None where there is none.
            held: Where they were held; None where none was.
        """
        far = self._episodes.count_within(distance > self._epsilon)  # False also where the distance is no number
        reached = ~far
        if self._goes_on:
            reached, self._inside = reached & ~self._inside, reached
        if struck is not None:
            reached = reached & ~struck
        self._until_horizon -= 1
        terminated = np.greater_equal(ground, far)  # on the ground, or not far
        if struck is not None:
            terminated = terminated | struck
        if self._until_horizon > 0 and not np.count_nonzero(terminated) and held is None:
            return reached, terminated, terminated.copy()  # none in either
        terminated, truncated = self._mark(ground, reached, struck, held)
        return reached, terminated, truncated

    def forget(self) -> None:
        """Clear the record of flags and event terms."""
        self._episodes.flags[...] = 0.0
        self._episodes.events[...] = 0.0
        self.marked = False

    def state(self) -> dict[str, Any]:
        """Everything that `restore` needs beside the episodes' matrix."""
        return {"inside": self._inside.copy(), "until_horizon": self._until_horizon, "events": self.marked}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on from `state`, which the method of this name returned."""
        self._inside, self._until_horizon = state["inside"].copy(), int(state["until_horizon"])
        self.marked = bool(state["events"])

    def _mark(self, ground: Mask, reached: Mask, struck: Mask | None, held: Mask | None) -> tuple[Mask, Mask]:
        """Flags and event terms into the record; returns where episodes are terminated and truncated."""
        episodes = self._episodes
        terminated = ground | reached if not self._goes_on else ground.copy()
        if struck is not None:
            terminated |= struck
        truncated = (episodes.step >= self._horizon) & ~terminated
        held = np.zeros_like(ground) if held is None else held
        for column, flag in enumerate((ground, reached, held, terminated, truncated)):
            episodes.flags[:, column] = flag
        episodes.events[:, 0] = ground * self._task.ground_reward
        if struck is not None:
            episodes.events[:, 0] += struck * conditions_of(self._task).obstacle_reward
        if reached.any():
            episodes.events[reached, 1] = self._task.target_rewards(self._robot, episodes.qpos[reached])
        self.marked = True
        return terminated, truncated
