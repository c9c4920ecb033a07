"""One robot arm: its URDF, and the few numbers beside it in `robot.toml` that a URDF has no place for."""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from harness.arrays import Float
from harness.errors import UsageError
from harness.robot.chain_end import find_tip
from harness.robot.joint_limits import origin, read_numbers
from harness.robot.kinematics import Chain, build_chain, chain_length, end_effector_position, position_jacobian
from harness.robot.normal_urdf import plain_urdf
from harness.robot.settings import FILE, JOINT_KEYS, RobotFile, read_robot_file, read_text
from harness.robot.shapes import attach_shapes
from harness.robot.urdf import Joint, read_chain

FEWEST_JOINTS, MOST_JOINTS = 3, 8


@dataclass(frozen=True, eq=False)
class Robot:
    """One arm with `dof` joints that turn or slide, standing on the world's origin.

    All arrays are read-only float64 of shape (dof,), in the order of the chain from the root link. Where a joint
    slides, read m for rad.

    Attributes:
        name: What the robot calls itself.
        urdf: Text of a URDF with nothing left to guess, for all simulators; see `harness.robot.normal_urdf`.
        folder: Of the URDF's file.
        end_effector_link: The link whose origin is the end effector.
        joint_names: Names of the driven joints in the URDF.
        lower: Smallest joint positions [rad]; -pi where the URDF has a continuous joint.
        upper: Largest joint positions [rad]; pi where the URDF has a continuous joint.
        max_speed: Largest joint speeds, positive [rad/s].
        max_acceleration: Largest joint accelerations, positive [rad/s^2].
        home: A resting pose within the limits [rad].
        chain: The kinematic chain from the root link to the end effector.
        origins: Where the end effector, home, speeds and accelerations come from, in words.
    """

    name: str
    urdf: str = field(repr=False)
    folder: Path
    end_effector_link: str
    joint_names: tuple[str, ...]
    lower: Float
    upper: Float
    max_speed: Float
    max_acceleration: Float
    home: Float
    chain: Chain = field(repr=False)
    origins: Mapping[str, str] = field(repr=False)

    @property
    def digest(self) -> str:
        """SHA-256 of all that decides how the arm moves: the URDF with its meshes' paths, and the numbers beside it."""
        numbers = np.stack([self.lower, self.upper, self.max_speed, self.max_acceleration, self.home])
        parts = (self.urdf.encode(), self.end_effector_link.encode(), numbers.tobytes())
        return hashlib.sha256(b"\0".join(parts)).hexdigest()

    @property
    def dof(self) -> int:
        """Number of driven joints."""
        return self.chain.dof

    @property
    def reach(self) -> float:
        """No end effector position is farther than this from the first joint's origin: the chain stretched out [m]."""
        return chain_length(self.chain, self.lower, self.upper)

    def end_effector(self, qpos: ArrayLike) -> Float:
        """The end effector's position in the world frame.

        Args:
            qpos: Joint positions [rad] or [m], shape (..., dof).

        Returns:
            [m], shape (..., 3).

        Raises:
            UsageError: The last axis of qpos is not dof long.
        """
        return end_effector_position(self.chain, qpos)

    def jacobian(self, qpos: ArrayLike) -> Float:
        """The derivative of the end effector's position by the joint positions, world frame.

        Args:
            qpos: Joint positions [rad] or [m], shape (..., dof).

        Returns:
            [m/rad], for a sliding joint [m/m], shape (..., 3, dof).

        Raises:
            UsageError: The last axis of qpos is not dof long.
        """
        return position_jacobian(self.chain, qpos)


def read_robot(path: Path) -> Robot:
    """The robot of a folder or a URDF.

    Args:
        path: A folder whose `robot.toml` names the URDF; or a URDF, beside which a `robot.toml` may lie that names it
            or none. Of one that names another URDF nothing is taken.

    Returns:
        The robot, every number checked.

    Raises:
        UsageError: A file cannot be read or says something that cannot be; the message starts with the file.
    """
    file, urdf_path = _find_files(path)
    text, folder = read_text(urdf_path), urdf_path.parent
    with _naming(urdf_path):
        tip = file.text("end_effector") or find_tip(text)
        joints = read_chain(text, tip)
        driven = [joint for joint in joints if joint.kind != "fixed"]
        _check_count(driven, tip)
        names = tuple(joint.name for joint in driven)
        urdf = plain_urdf(text, names, folder)
        shapes = attach_shapes(urdf, names)
    chain = build_chain(joints)
    numbers = read_numbers(file, urdf_path, driven, chain, shapes)
    return Robot(
        name=file.text("name") or urdf_path.stem,
        urdf=urdf,
        folder=folder,
        end_effector_link=tip,
        joint_names=names,
        lower=numbers.lower,
        upper=numbers.upper,
        max_speed=numbers.max_speed,
        max_acceleration=numbers.max_acceleration,
        home=numbers.home,
        chain=chain,
        origins=_origins(file, driven),
    )


def _find_files(path: Path) -> tuple[RobotFile, Path]:
    """The robot.toml, empty where there is none, and the URDF's path."""
    if path.is_dir():
        file = read_robot_file(path / FILE)
        if file.text("urdf") is None:
            raise UsageError(
                f"{file.path}: missing urdf. Name the URDF's file, or give its path instead of the folder."
            )
        return file, path / file.settings["urdf"]
    beside = path.parent / FILE
    if beside.is_file():
        file = read_robot_file(beside)
        if file.text("urdf") in {None, path.name}:
            return file, path
    return RobotFile(beside), path


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Put the file before what is wrong with it."""
    try:
        yield
    except UsageError as error:
        raise UsageError(f"{path}: {error}") from error


def _check_count(driven: Sequence[Joint], tip: str) -> None:
    if not FEWEST_JOINTS <= len(driven) <= MOST_JOINTS:
        raise UsageError(
            f"{len(driven)} joints move between the root link and '{tip}'; allowed: {FEWEST_JOINTS} to {MOST_JOINTS}. "
            f"Fix some, or name another end_effector in a {FILE}."
        )


def _origins(file: RobotFile, driven: Sequence[Joint]) -> Mapping[str, str]:
    tip = FILE if file.text("end_effector") else "the end of the chain"
    return {"end_effector": tip, **{quantity: origin(file, quantity, driven) for quantity in JOINT_KEYS}}
