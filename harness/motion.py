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
        if (np.abs(qpos - self._middle) > self._free).any():
            # The brake never asks for more than max_change: `high` of one side is at least what the other allows.
            speed = np.minimum(speed, np.maximum(self._stopping_speed(self.upper - qpos), low))
            speed = np.maximum(speed, np.minimum(-self._stopping_speed(qpos - self.lower), high))
        target = np.minimum(np.maximum(qpos + speed * self.period, self.lower), self.upper)
        return target, speed

    def __post_init__(self) -> None:
        periods = np.ceil(self.max_speed / self.max_change) + 1.0
        brake = self.max_change * self.period * periods * (periods + 1.0) / 2.0
        object.__setattr__(self, "_middle", (self.lower + self.upper) / 2.0)
        # Within this half-width no speed needs braking: most steps skip the square roots.
        object.__setattr__(self, "_free", (self.upper - self.lower) / 2.0 - brake)

    def _stopping_speed(self, room: Float) -> Float:
        """The largest speed from which a joint stops within `room` when it brakes by `max_change` every period.

        In units of max_change a speed x = k + f (k whole, 0 <= f < 1) covers, this period included,
        x + (x - 1) + ... + f = (k + 1) x - k (k + 1) / 2 units of max_change * period; solved for x.
        """
        units = np.maximum(room, 0.0) / (self.max_change * self.period)
        k = np.floor((np.sqrt(1.0 + 8.0 * units) - 1.0) / 2.0)
        speed: Float = self.max_change * (k + (units - k * (k + 1.0) / 2.0) / (k + 1.0))
        return speed
