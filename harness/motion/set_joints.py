"""The published baseline's action: the arm jumps to joint positions."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from harness.arrays import Float
from harness.motion.limits import JointLimits, require_numbers
from harness.motion.motion import Move, Setting
from harness.motion.move_j_absolute import INCREMENT


@dataclass(frozen=True)
class SetJointsMode:
    """Joint positions are SET, without dynamics: -1 is the lower end of a joint's range, 1 the upper."""

    def motion(self, setting: Setting) -> "SetJoints":
        """The motion of one arm."""
        return SetJoints(setting.limits())


@dataclass(frozen=True, eq=False)
class SetJoints:
    """See `SetJointsMode`."""

    limits: JointLimits
    jumps: ClassVar[bool] = True

    @property
    def action_size(self) -> int:
        """One number per joint."""
        return len(self.limits.middle)

    def advance(self, qpos: Float, qvel: Float, action: Float) -> Move:
        """See `harness.motion.motion.Motion`."""
        target = self.limits.position(action)
        require_numbers(target)
        return Move((target,), np.zeros_like(qvel))

    def stay(self, qpos: Float) -> Float:
        """The positions themselves."""
        return self.limits.normalised(qpos)

    def increments(self) -> Float:
        """Each joint by a tenth of half its range."""
        return INCREMENT * np.eye(self.action_size)
