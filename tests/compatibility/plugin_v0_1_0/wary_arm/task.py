"""The task."""

from typing import ClassVar

import numpy as np
from pydantic.dataclasses import dataclass

from harness.inverse import reach_position
from harness.observation import ArmObservation
from harness.reach import ReachTask
from harness.robot import Robot
from harness.task import Float, Targets


@dataclass(frozen=True)
class WaryReach(ReachTask):
    """Targets on a line in front of the arm."""

    registered_name: ClassVar[str] = "wary-reach"

    def observation(self, robot: Robot) -> ArmObservation:
        """See `harness.task.Task`."""
        return ArmObservation(robot, self.control_period)

    def draw_targets(self, robot: Robot, rng: np.random.Generator, count: int) -> Targets:
        """See `harness.task.Task`."""
        height: Float = rng.uniform(-0.1, 0.1, count)
        points = robot.end_effector(robot.home)[None] + np.stack([0 * height, 0 * height, height], axis=1)
        _, is_there = reach_position(robot, points, np.tile(robot.home, (count, 1)))
        return Targets(np.where(is_there[:, None], points, points[:1]), np.zeros(count, bool))
