"""The reach task with targets in a narrow place, just above the ground."""

from typing import Annotated

import numpy as np
from pydantic import Field, PositiveFloat
from pydantic.dataclasses import dataclass

from harness import Float
from harness.robot import Robot
from harness.task import ReachTask, place_box

CENTER = np.array([0.75, 0.0, 0.06])
HALF_EXTENT = np.array([0.15, 0.5, 0.02])
"""Half the edges of the box of targets, (3,), [m]. It and its centre were chosen for the FD100."""


@dataclass(frozen=True)
class Low(ReachTask):
    """The task `fd100-reach` with targets in a flat box just above the ground, to be reached within 2 cm.

    The arm has to fold down to the targets from above. If its path is too steep or too fast for the arm to stop in
    time, it hits the ground, and the episode ends.
    """

    epsilon: Annotated[
        PositiveFloat, Field(description="distance within which the target is reached, NOTE eq. 20 [m]")
    ] = 0.02

    def target_box(self, robot: Robot) -> tuple[Float, Float]:
        """Centre and half edges of the box of targets, (3,) both, [m]."""
        center, half = place_box(robot, CENTER, HALF_EXTENT)
        center[2], half[2] = robot.scale * CENTER[2], robot.scale * HALF_EXTENT[2]  # the ground stays where it is
        center = center if self.target_center is None else np.array(self.target_center)
        half = half if self.target_half_extent is None else np.array(self.target_half_extent)
        return center, half
