"""Targets in a narrow place, low over the ground."""

from typing import Annotated

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.arrays import Float
from harness.reach import FD100_REACH, Positive, ReachTask
from harness.robot import Robot

CENTER = np.array([0.75, 0.0, 0.06])
HALF_EXTENT = np.array([0.15, 0.5, 0.02])
"""[m]; chosen for the FD100."""


@dataclass(frozen=True)
class Low(ReachTask):
    """As `fd100-reach`, with targets in a flat box just above the ground, and within 2 cm.

    The arm has to fold down to them from above. A path that is steeper or faster than it can be stopped ends on the
    ground, and with it the episode.
    """

    epsilon: Annotated[Positive, Field(description="the target is reached within this distance, NOTE eq. 20 [m]")] = (
        0.02
    )

    def target_box(self, robot: Robot) -> tuple[Float, Float]:
        """Centre and half edges of the box of targets, (3,) both, [m]."""
        scale = robot.reach / FD100_REACH
        center = scale * CENTER if self.target_center is None else np.array(self.target_center)
        half = scale * HALF_EXTENT if self.target_half_extent is None else np.array(self.target_half_extent)
        return center, half
