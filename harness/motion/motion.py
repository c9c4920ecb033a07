"""What turns an action into joint targets for one control period, within the joints' limits: motions by the joints."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from harness.arrays import Float, Mask
from harness.robot import Robot


class Rows(NamedTuple):
    """What every step takes, as (1, dof): for one arm numpy is twice as quick with it as with (dof,)."""

    max_change: Float
    max_change_down: Float
    middle: Float
    period: Float


@dataclass(frozen=True, eq=False)
class JointLimits:
    """Limits for joints that move at constant speed within a period.

    A speed changes by at most `max_change` from one period to the next, and is low enough that at this deceleration
    the joint stops before the end of its range.

    Attributes:
        lower: Ends of the joint ranges, (dof,), [rad].
        upper: The same.
        max_speed: Largest speeds, (dof,), [rad/s].
        max_change: Largest change of speed from one period to the next, (dof,), [rad/s].
        period: Duration of a period, [s].
    """

    lower: Float
    upper: Float
    max_speed: Float
    max_change: Float
    period: float
    middle: Float = field(init=False)
    half_range: Float = field(init=False)
    _rows: Rows = field(init=False)
    _free: Float = field(init=False)
    _ends: Float = field(init=False)

    def advance(self, qpos: Float, qvel: Float, wanted: Float) -> tuple[Float, Float]:
        """Joint targets and speeds of the next period.

        Args:
            qpos: Joint targets of the last period, (num_envs, dof), [rad].
            qvel: Joint speeds of the last period, (num_envs, dof), [rad/s].
            wanted: Joint speeds, (num_envs, dof), none above max_speed, [rad/s].

        Returns:
            Joint targets at the end of the period, (num_envs, dof), [rad], and the constant speeds that lead there.
        """
        rows = self._rows
        speed = wanted - qvel
        np.minimum(speed, rows.max_change, out=speed)
        np.maximum(speed, rows.max_change_down, out=speed)
        speed += qvel
        target = speed * rows.period
        target += qpos
        # From near enough to the middle every speed can be braked: most steps skip the square roots.
        distance = target - rows.middle
        is_free = np.abs(distance, out=distance) <= self._free
        if np.count_nonzero(is_free) == target.size:
            return target, speed
        near_an_end = np.flatnonzero(~is_free.all(axis=1))
        if len(near_an_end) == len(target):
            return self._braked(qpos, qvel, speed)
        target[near_an_end], speed[near_an_end] = self._braked(qpos[near_an_end], qvel[near_an_end], speed[near_an_end])
        return target, speed

    def bounds(self, qpos: Float, qvel: Float) -> tuple[Float, Float]:
        """The lowest and the highest speed that each joint may have in the next period, (num_envs, dof) both."""
        lowest = np.maximum(qvel - self.max_change, -self.max_speed)
        highest = np.minimum(qvel + self.max_change, self.max_speed)
        low, high = self._braking_bounds(qpos, qvel)
        low = np.minimum(np.maximum(low, lowest), highest)
        return low, np.maximum(np.minimum(high, highest), low)

    def stopping_speed(self, room: Float) -> Float:
        """The largest speed from which a joint stops within `room`, (..., dof), [rad]; 0 where there is none."""
        return stopping_speed(room, self.max_change, self.period)

    def normalised(self, qpos: Float) -> Float:
        """Positions in the joint ranges, -1 lower end, 1 upper end, (..., dof)."""
        return (qpos - self.middle) / self.half_range

    def position(self, share: Float) -> Float:
        """The inverse of `normalised`; beyond the ends of a range, the ends."""
        return np.minimum(np.maximum(self.middle + share * self.half_range, self.lower), self.upper)

    def __post_init__(self) -> None:
        middle, half_range = (self.lower + self.upper) / 2.0, (self.upper - self.lower) / 2.0
        # What a joint at full speed covers until it stands, the period it is in not counted.
        x = self.max_speed / self.max_change
        k = np.floor(x)
        brake = (k * x - k * (k + 1.0) / 2.0) * self.max_change * self.period
        derived = {
            "middle": middle,
            "half_range": half_range,
            "_rows": Rows(self.max_change[None], -self.max_change[None], middle[None], np.array(self.period)),
            "_free": (half_range * (1.0 - ROUNDING) - brake)[None],
            "_ends": np.stack([self.upper, -self.lower])[:, None],
        }
        for name, value in derived.items():
            object.__setattr__(self, name, value)

    def _braked(self, qpos: Float, qvel: Float, speed: Float) -> tuple[Float, Float]:
        """The same as `advance`, for speeds that differ from the last ones by what is allowed: slow enough to stop."""
        low, high = self._braking_bounds(qpos, qvel)
        speed = np.maximum(np.minimum(speed, high), low)
        return np.minimum(np.maximum(qpos + speed * self.period, self.lower), self.upper), speed

    def _braking_bounds(self, qpos: Float, qvel: Float) -> tuple[Float, Float]:
        """Between these speeds a joint stops in its range.

        Braking never takes more than max_change: where that is not enough, the step before was allowed too much.
        """
        up, down = self.stopping_speed(self._ends - _SIGNS * qpos)
        return np.minimum(-down, qvel + self.max_change), np.maximum(up, qvel - self.max_change)


def stopping_speed(room: Float, max_change: Float, period: float) -> Float:
    """The largest speed from which something stops within `room` [m] or [rad]; 0 where there is none.

    It brakes by max_change every period. In units of max_change a speed x = k + f (k whole, 0 <= f < 1) covers, this
    period included, x + (x - 1) + ... + f = (k + 1) x - k (k + 1) / 2 units of max_change * period; this, solved for x.
    """
    twice = np.maximum(room * (2.0 / (max_change * period)), 0.0)
    k = np.floor(np.sqrt(twice + 0.25) - 0.5)
    speed: Float = (twice / (k + 1.0) + k) * (0.5 * max_change)
    return speed


ROUNDING = 1e-12
"""So near to an end of its range, as a share of it, a joint is not called free: rounding could take it beyond."""
_SIGNS = np.array([1.0, -1.0])[:, None, None]


@dataclass(frozen=True, eq=False)
class Setting:
    """What a task gives to a motion.

    Attributes:
        robot: The arm.
        period: Control period, [s].
        speed: Fraction of the joints' maximum speed that may be used, NOTE Table I.
        acceleration: The same for the acceleration.
    """

    robot: Robot
    period: float
    speed: float = 1.0
    acceleration: float = 1.0

    def limits(self, parts: int = 1) -> JointLimits:
        """The joints' limits for periods that are `parts` times shorter than the control period."""
        period = self.period / parts
        change = self.acceleration * self.robot.max_acceleration * period
        return JointLimits(self.robot.lower, self.robot.upper, self.speed * self.robot.max_speed, change, period)


class Move(NamedTuple):
    """The command of one control period."""

    waypoints: Sequence[Float]
    """Joint targets, (num_envs, dof) each, reached one after the other in equal parts of the period, [rad]."""
    qvel: Float
    """Constant speeds that lead to the last of them, (num_envs, dof), [rad/s]."""
    held: Mask | None = None
    """Which arms were held still because they cannot do the motion, (num_envs,); None if all can."""


class Motion(Protocol):
    """Turns actions in [-1, 1] into moves."""

    @property
    def action_size(self) -> int:
        """How many numbers an action has."""

    @property
    def jumps(self) -> bool:
        """Whether the arm is put at its targets, without dynamics, instead of being driven there."""

    def advance(self, qpos: Float, qvel: Float, action: Float) -> Move:
        """The move that an action asks for.

        Args:
            qpos: Joint targets of the last period, (num_envs, dof), [rad].
            qvel: Joint speeds of the last period, (num_envs, dof), [rad/s].
            action: (num_envs, action_size); clipped to [-1, 1].
        """

    def stay(self, qpos: Float) -> Float:
        """Actions that keep arms where they are, (num_envs, action_size), for joint targets `qpos`."""

    def increments(self) -> Float:
        """The elementary actions of the mode, (count, action_size). A discrete choice is plus or minus one of them."""


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
        object.__setattr__(self, "_full", self.limits.max_speed[None])  # (1, dof), see harness.motion.motion.Rows

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
