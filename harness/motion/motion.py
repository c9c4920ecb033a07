"""The interface of a motion: what turns an action into joint targets for one control period."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from harness.arrays import Float, Mask
from harness.motion.limits import JointLimits
from harness.robot import Robot


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
