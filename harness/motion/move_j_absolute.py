"""Joint movement: an action is a joint position."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from harness.arrays import Float
from harness.motion.limits import JointLimits
from harness.motion.motion import Move, Setting

INCREMENT = 0.1
"""The way of a discrete choice, as a share of half a joint's range."""


@dataclass(frozen=True)
class MoveJAbsoluteMode:
    """MoveJ to explicit joint positions: -1 is the lower end of a joint's range, 1 the upper.

    The joints move towards them as fast as their limits allow, and stop there without overshoot.
    """

    def motion(self, setting: Setting) -> "MoveJAbsolute":
        """The motion of one arm."""
        return MoveJAbsolute(setting.limits())


@dataclass(frozen=True, eq=False)
class MoveJAbsolute:
    """See `MoveJAbsoluteMode`."""

    limits: JointLimits
    jumps: ClassVar[bool] = False

    @property
    def action_size(self) -> int:
        """One number per joint."""
        return len(self.limits.middle)

    def advance(self, qpos: Float, qvel: Float, action: Float) -> Move:
        """See `harness.motion.motion.Motion`."""
        room = self.limits.position(action) - qpos
        fastest = np.minimum(self.limits.stopping_speed(np.abs(room)), self.limits.max_speed)
        target, speed = self.limits.advance(qpos, qvel, np.copysign(fastest, room))
        return Move((target,), speed)

    def stay(self, qpos: Float) -> Float:
        """The positions themselves."""
        return self.limits.normalised(qpos)

    def increments(self) -> Float:
        """Each joint by a tenth of half its range."""
        return INCREMENT * np.eye(self.action_size)
