"""The interface that a simulator fills. It knows joints and metres, never tasks or rewards."""

from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.errors import UsageError
from harness.face import face_of
from harness.robot import Robot
from harness.robot.joint_limits import Servo
from harness.robot.settings import FILE, SERVO

if TYPE_CHECKING:
    from harness.authoring.ground_contact import GroundContact as GroundContact
    from harness.authoring.servo_track import ServoTrack as ServoTrack
    from harness.authoring.substeps import Substeps as Substeps
    from harness.scene.picture import Camera as Camera, StillFrames as StillFrames
else:
    __all__, __getattr__ = face_of(__name__, "Simulation", "Simulator", "State", "servo_of")


class State(NamedTuple):
    """What a simulation reads from its engine. Frame: world, right-handed, z up, origin at the robot's base.

    The arrays belong to the simulation. They are valid until its next call: copy what you want to keep.
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

    It may also have ``rest(mask)``. It says that nobody needs the robots in `mask`, (num_envs,), until they are reset,
    so the engine need not move them. Evaluations are faster with it, since most episodes end long before the last one.
    """

    def reset(self, qpos: Float, mask: Mask) -> State:
        """Put the robots in `mask` at rest at joint positions `qpos`, (num_envs, dof); leave the others alone."""

    def drive(self, qpos: Float, duration: float) -> State:
        """Drive each joint at constant speed towards its target `qpos`, (num_envs, dof), for `duration` [s].

        The duration is the control period. If a motion goes in several pieces, it is a whole part of that period.

        Raises:
            UsageError: The engine cannot divide the control period in this way.
        """

    def place(self, qpos: Float) -> State:
        """Put all robots at rest at `qpos`, (num_envs, dof), without dynamics; overwrites the engine's state."""

    def read(self) -> State:
        """The present state."""

    def render(self, env: int, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """One frame of env number `env` with a marker at `target`, (3,), [m]; RGB, (height, width, 3).

        Raises:
            UsageError: This machine cannot render; says what to install.
        """

    def close(self) -> None:
        """Release the engine; a second call does nothing."""


class Simulator(Protocol):
    """A frozen dataclass whose fields are the engine's settings.

    It may also have a class variable ``family``, see `family_of`; and one ``arm_bytes``, how much memory an
    arm takes, see `harness.env.vector_env.World.batches`.
    """

    def open(self, robot: Robot, num_envs: int, control_period: float) -> Simulation:
        """Start `num_envs` robots.

        Args:
            robot: The arm; its URDF is the single source of truth.
            num_envs: How many, >= 1.
            control_period: The longest duration that `drive` will be called with, [s].
        """


def family_of(simulator: object) -> str | None:
    """The engine that a simulator, or its class, computes with; None if it uses no engine.

    It is the class variable ``family``, such as "MuJoCo". Simulators of one family solve the same equations with the
    same code, so their agreement is the result of one engine only. A simulator without this variable is a family of its
    own, named by its class.
    """
    kind = simulator if isinstance(simulator, type) else type(simulator)
    family: str | None = getattr(kind, "family", kind.__name__)
    return family


def require_drives(simulator: object, robot: Robot) -> None:
    """Check that an arm has drives, if the simulator's field ``drive`` is "servo".

    Raises:
        UsageError: As `servo_of`.
    """
    if drives_with_servo(simulator):
        servo_of(robot)


def drives_with_servo(simulator: object) -> bool:
    """Whether a simulator is set to move an arm by the drives of its robot.toml, `harness.robot.joint_limits.Servo`."""
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
