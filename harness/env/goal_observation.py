"""What the learner sees of a task that asks for more than a point that stays."""

import numpy as np

from harness.arrays import Float32
from harness.env.arm_observation import ArmObservation
from harness.env.episodes import Episodes
from harness.robot import Robot
from harness.task import Goal


class GoalObservation(ArmObservation):
    """`ArmObservation` with the goal's error in place of the distance, then what `harness.task.Goal.observe` tells.

    The target is where it is now, the offset target - end effector. Every number is cut off at its bounds: the error at
    twice the arm's extent, whatever its unit.
    """

    def __init__(self, robot: Robot, period: float, goal: Goal) -> None:
        super().__init__(robot, period)
        self.goal = goal
        self._least, self._most = goal.bounds()

    @property
    def low(self) -> Float32:
        """Lower bounds, (size,)."""
        return np.concatenate([super().low, self._least.astype(np.float32)])

    @property
    def high(self) -> Float32:
        """Upper bounds, (size,)."""
        return np.concatenate([super().high, self._most.astype(np.float32)])

    def observe(self, episodes: Episodes) -> Float32:
        """See `harness.task.Observation`."""
        more = np.clip(self.goal.observe(episodes.situation), self._least, self._most)
        return np.concatenate([super().observe(episodes), more.astype(np.float32)], axis=1)
