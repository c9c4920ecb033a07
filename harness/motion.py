"""Motion commands of NOTE Table II: how an action becomes joint targets within the robot's limits."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from harness.robot import Robot

Float = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MoveJ:
    """Joint movement: each action is a joint speed, as a fraction of the joint's maximum.

    A joint moves at constant speed within a control period. Its speed changes by at most `max_change` from one
    period to the next, and is low enough that at this deceleration it stops before the end of its range.

    Attributes:
        lower: Ends of the joint ranges, (dof,), [rad].
        upper: The same.
        max_speed: What a full action asks for, (dof,), [rad/s].
        max_change: Largest change of speed from one period to the next, (dof,), [rad/s].
        period: Control period, [s].
    """

    lower: Float
    upper: Float
    max_speed: Float
    max_change: Float
    period: float
    _middle: Float = field(init=False)
    _free: Float = field(init=False)
    _ends: Float = field(init=False)
    _per_unit: Float = field(init=False)

    @classmethod
    def within_limits(cls, robot: Robot, speed: float, acceleration: float, period: float) -> "MoveJ":
        """MoveJ of `robot` at most at the fractions `speed` and `acceleration` of its maxima, NOTE Table I."""
        max_speed = speed * robot.max_speed
        return cls(robot.lower, robot.upper, max_speed, acceleration * robot.max_acceleration * period, period)

    def advance(self, qpos: Float, qvel: Float, action: Float) -> tuple[Float, Float]:
        """Joint targets and speeds of the next control period.

        Args:
            qpos: Joint targets of the last period, (num_envs, dof), [rad].
            qvel: Joint speeds of the last period, (num_envs, dof), [rad/s].
            action: (num_envs, dof); clipped to [-1, 1].

        Returns:
            Joint targets at the end of the period, (num_envs, dof), [rad], and the constant speeds that lead there.
        """
        wanted = np.minimum(np.maximum(action, -1.0), 1.0) * self.max_speed
        low, high = qvel - self.max_change, qvel + self.max_change
        speed = np.minimum(np.maximum(wanted, low), high)
        if np.logical_or.reduce(np.abs(qpos - self._middle) > self._free, axis=None):
            # Braking never takes more than max_change: where `low` or `high` is stricter, so was the step before.
            up, down = self._stopping_speeds(qpos)
            speed = np.minimum(speed, np.maximum(up, low))
            speed = np.maximum(speed, np.minimum(-down, high))
            return np.minimum(np.maximum(qpos + speed * self.period, self.lower), self.upper), speed
        return qpos + speed * self.period, speed

    def __post_init__(self) -> None:
        x = self.max_speed / self.max_change
        k = np.floor(x)
        brake = ((k + 1.0) * x - k * (k + 1.0) / 2.0) * self.max_change * self.period
        derived = {
            "_middle": (self.lower + self.upper) / 2.0,
            # Within this half-width no speed needs braking: most steps skip the square roots.
            "_free": (self.upper - self.lower) / 2.0 - brake,
            "_ends": np.stack([self.upper, -self.lower])[:, None],
            "_per_unit": 2.0 / (self.max_change * self.period),
        }
        for name, value in derived.items():
            object.__setattr__(self, name, value)

    def _stopping_speeds(self, qpos: Float) -> Float:
        """The largest speeds up and down from which a joint stops within its range, (2, num_envs, dof), >= 0.

        It brakes by max_change every period. In units of max_change a speed x = k + f (k whole, 0 <= f < 1) covers,
        this period included, x + (x - 1) + ... + f = (k + 1) x - k (k + 1) / 2 units of max_change * period; this,
        solved for x.
        """
        room = self._ends - _SIGNS * qpos
        twice = np.maximum(room * self._per_unit, 0.0)
        k = np.floor(np.sqrt(twice + 0.25) - 0.5)
        speeds: Float = (twice / (k + 1.0) + k) * (0.5 * self.max_change)
        return speeds


_SIGNS = np.array([1.0, -1.0])[:, None, None]
