"""The interface that a simulator fills. It knows joints and metres, never tasks or rewards."""

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.errors import UsageError
from harness.robot import Robot
from harness.robot.servo import Servo
from harness.robot.settings import FILE, SERVO


class State(NamedTuple):
    """What a simulation reads from its engine. Frame: world, right-handed, z up, origin at the robot's base.

    The arrays belong to the simulation and hold until its next call: copy what must last.
    """

    qpos: Float
    """Joint positions, (num_envs, dof), [rad] or [m]."""
    qvel: Float
    """Joint velocities, (num_envs, dof), [rad/s] or [m/s]."""
    end_effector: Float
    """Position of the end effector, (num_envs, 3), [m]."""
    ground_contact: Mask
    """Whether a moving link touches the ground z = 0, (num_envs,)."""


class Simulation(Protocol):
    """`num_envs` robots in one running engine, each in a world of its own.

    It may also have ``rest(mask)``: nobody looks at the robots in `mask`, (num_envs,), until they are reset, and the
    engine may leave them as they are. Evaluations are quicker with it: most episodes end long before the last one.
    """

    def reset(self, qpos: Float, mask: Mask) -> State:
        """Put the robots in `mask` at rest at joint positions `qpos`, (num_envs, dof); leave the others alone."""

    def drive(self, qpos: Float, duration: float) -> State:
        """Drive each joint at constant speed towards its target `qpos`, (num_envs, dof), for `duration` [s].

        The duration is the control period or, for a way in several pieces, a whole part of it.

        Raises:
            UsageError: The engine cannot divide the control period so.
        """

    def place(self, qpos: Float) -> State:
        """Put all robots at `qpos`, (num_envs, dof), without dynamics: at rest, engine state overwritten."""

    def read(self) -> State:
        """The state as it stands."""

    def render(self, env: int, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """One frame of env number `env` with a marker at `target`, (3,), [m]; RGB, (height, width, 3).

        Raises:
            UsageError: This machine cannot render; says what to install.
        """

    def close(self) -> None:
        """Release the engine; a second call does nothing."""


class Simulator(Protocol):
    """A frozen dataclass whose fields are the engine's settings.

    It may also have a class variable ``family``, see `family_of`, and what ``harness bench`` times it beside:

    * ``bare_loop(robot, targets, period)``: the engine without the harness. It returns a function without arguments
      that drives the robots once along `targets`, (periods, num_envs, dof), one after another, each in `period` [s]; it
      is called again and again, and the motion is closed. Whatever can be computed before is not the engine's.
    * ``peer_envs()``: environments of other people that do the like, by name; each a function that makes a
      `gymnasium.Env` of one robot, and raises `UsageError` where its library is not installed.
    """

    def open(self, robot: Robot, num_envs: int, control_period: float) -> Simulation:
        """Start `num_envs` robots.

        Args:
            robot: The arm; its URDF is the single source of truth.
            num_envs: How many, >= 1.
            control_period: The longest duration that `drive` will be called with, [s].
        """


def family_of(simulator: object) -> str | None:
    """The engine that a simulator, or its class, computes with; None where it is none.

    It is the class variable ``family``, such as "MuJoCo". Simulators of one family solve the same equations by the same
    code: where they agree, one engine has spoken. Without it a simulator is a family of its own, by its class's name.
    """
    kind = simulator if isinstance(simulator, type) else type(simulator)
    family: str | None = getattr(kind, "family", kind.__name__)
    return family


def require_drives(simulator: object, robot: Robot) -> None:
    """See that an arm has the drives that a simulator moves it by, where its field ``drive`` says "servo".

    Raises:
        UsageError: As `servo_of`.
    """
    if drives_with_servo(simulator):
        servo_of(robot)


def drives_with_servo(simulator: object) -> bool:
    """Whether a simulator is set to move an arm by the drives of its robot.toml, `harness.robot.servo.Servo`."""
    return getattr(simulator, "drive", None) == "servo"


def servo_of(robot: Robot) -> Servo:
    """The drives of an arm, for a simulator that is told ``drive=servo``.

    Raises:
        UsageError: Its robot.toml describes none.
    """
    if robot.servo is None:
        raise UsageError(
            f"Robot '{robot.name}' has no drives to simulate: its {FILE} has no table [{SERVO}]. "
            "Write one (docs/drives.md), or leave drive at ideal."
        )
    return robot.servo
