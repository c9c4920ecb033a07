"""What joints can do from one period to the next: range, speed and acceleration."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from harness.arrays import Float


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
