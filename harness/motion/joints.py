"""Joint motions, NOTE Table II: an action is a speed, an angle or a whole position of the joints."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from harness.arrays import Float
from harness.motion.limits import JointLimits
from harness.motion.motion import Move, Setting
from harness.robot import Robot

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


@dataclass(frozen=True)
class MoveJMode:
    """MoveJ: each action is a joint speed, as a fraction of the largest that the task allows."""

    def motion(self, setting: Setting) -> "MoveJ":
        """The motion of one arm."""
        return MoveJ(setting.limits())


@dataclass(frozen=True, eq=False)
class MoveJ:
    """See `MoveJMode`. A full action asks for `limits.max_speed`."""

    limits: JointLimits
    _full: Float = field(init=False)
    jumps: ClassVar[bool] = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "_full", self.limits.max_speed[None])  # (1, dof), see harness.motion.limits.Rows

    @classmethod
    def within_limits(cls, robot: Robot, speed: float, acceleration: float, period: float) -> "MoveJ":
        """MoveJ of `robot` at most at the fractions `speed` and `acceleration` of its maxima, NOTE Table I."""
        return cls(Setting(robot, period, speed, acceleration).limits())

    @property
    def action_size(self) -> int:
        """One number per joint."""
        return len(self.limits.middle)

    def advance(self, qpos: Float, qvel: Float, action: Float) -> Move:
        wanted = np.minimum(action, _ONE)
        np.maximum(wanted, _MINUS_ONE, out=wanted)
        wanted *= self._full
        target, speed = self.limits.advance(qpos, qvel, wanted)
        return Move((target,), speed)

    def stay(self, qpos: Float) -> Float:
        """No speed."""
        return np.zeros_like(qpos)

    def increments(self) -> Float:
        """Each joint at full speed."""
        return np.eye(self.action_size)


_ONE, _MINUS_ONE = np.array(1.0), np.array(-1.0)
"""Arrays, because numpy turns a float into one at every call."""


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
        return Move((self.limits.position(action),), np.zeros_like(qvel))

    def stay(self, qpos: Float) -> Float:
        """The positions themselves."""
        return self.limits.normalised(qpos)

    def increments(self) -> Float:
        """Each joint by a tenth of half its range."""
        return INCREMENT * np.eye(self.action_size)
