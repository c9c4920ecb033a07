"""What the learner sees of a task that asks for more than a point that stays."""

import numpy as np

from harness.arrays import Float, Float32
from harness.env.arm_observation import ArmObservation
from harness.env.episodes import Episodes
from harness.goal import Goal
from harness.robot import Robot


class GoalObservation(ArmObservation):
    """`ArmObservation` with the goal's error in place of the distance, then what `harness.goal.Goal.observe` tells.

    Obstacles, where they are seen, come after that. The target is where it is now, the offset target - end effector.
    Every number is cut off at its bounds: the error at twice the arm's extent, whatever its unit.
    """

    def __init__(self, robot: Robot, period: float, goal: Goal, obstacles: int = 0) -> None:
        super().__init__(robot, period, obstacles)
        self.goal, self._usual = goal, 3 * robot.dof + 10
        self._least, self._most = goal.bounds()

    @property
    def low(self) -> Float32:
        """Lower bounds, (size,)."""
        return self._with(super().low, self._least)

    @property
    def high(self) -> Float32:
        """Upper bounds, (size,)."""
        return self._with(super().high, self._most)

    def observe(self, episodes: Episodes) -> Float32:
        """See `harness.task.Observation`."""
        more = np.clip(self.goal.observe(episodes.situation), self._least, self._most)
        return self._with(super().observe(episodes), more)

    def _with(self, seen: Float32, more: Float) -> Float32:
        """What is seen of arm, target and obstacles, (..., size), with the goal's numbers before the obstacles."""
        parts = (seen[..., : self._usual], more.astype(np.float32), seen[..., self._usual :])
        return np.concatenate(parts, axis=-1)
