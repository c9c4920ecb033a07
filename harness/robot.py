"""One robot arm: its URDF, and the few numbers beside it in `robot.toml` that a URDF has no place for.

A robot is a folder. Its `robot.toml` has exactly the keys in `KEYS`; angles there are in degrees, in Python in radians.
"""

import math
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harness.errors import UsageError
from harness.kinematics import Chain, build_chain, end_effector_position, position_jacobian
from harness.urdf import Joint, read_chain

Array = NDArray[np.float64]

TEXT_KEYS = ("name", "urdf", "end_effector")
JOINT_KEYS = ("home_deg", "max_speed_deg_s", "max_acceleration_deg_s2")
KEYS = TEXT_KEYS + JOINT_KEYS


@dataclass(frozen=True, eq=False)
class Robot:
    """One arm with `dof` turning joints, standing on the world's origin.

    All arrays are read-only float64 of shape (dof,), in the order of the chain from the root link.

    Attributes:
        name: What the robot calls itself.
        urdf: The URDF's text.
        folder: Where relative mesh paths in the URDF resolve.
        end_effector_link: The link whose origin is the end effector.
        joint_names: Names of the driven joints in the URDF.
        lower: Smallest joint positions [rad]; -pi where the URDF has a continuous joint.
        upper: Largest joint positions [rad]; pi where the URDF has a continuous joint.
        max_speed: Largest joint speeds, positive [rad/s].
        max_acceleration: Largest joint accelerations, positive [rad/s^2].
        home: A resting pose within the limits [rad].
        chain: The kinematic chain from the root link to the end effector.
    """

    name: str
    urdf: str = field(repr=False)
    folder: Path
    end_effector_link: str
    joint_names: tuple[str, ...]
    lower: Array
    upper: Array
    max_speed: Array
    max_acceleration: Array
    home: Array
    chain: Chain = field(repr=False)

    @property
    def dof(self) -> int:
        """Number of driven joints."""
        return self.chain.dof

    @property
    def reach(self) -> float:
        """No end effector position is farther than this from the first joint's origin: the chain stretched out [m]."""
        segments = np.vstack([self.chain.T_previous_joint[1:, :3, 3], self.chain.T_last_tip[:3, 3]])
        return float(np.linalg.norm(segments, axis=-1).sum())

    def end_effector(self, qpos: ArrayLike) -> Array:
        """The end effector's position in the world frame.

        Args:
            qpos: Joint positions [rad], shape (..., dof).

        Returns:
            [m], shape (..., 3).

        Raises:
            UsageError: The last axis of qpos is not dof long.
        """
        return end_effector_position(self.chain, qpos)

    def jacobian(self, qpos: ArrayLike) -> Array:
        """The derivative of the end effector's position by the joint positions, world frame.

        Args:
            qpos: Joint positions [rad], shape (..., dof).

        Returns:
            [m/rad], shape (..., 3, dof).

        Raises:
            UsageError: The last axis of qpos is not dof long.
        """
        return position_jacobian(self.chain, qpos)


def read_robot(folder: Path) -> Robot:
    """The robot that `folder` holds.

    Args:
        folder: Holds `robot.toml` and the URDF that it names.

    Returns:
        The robot, every number checked.

    Raises:
        UsageError: A file cannot be read or says something that cannot be; the message starts with the file.
    """
    path = folder / "robot.toml"
    settings = _read_settings(path)
    urdf_path = folder / settings["urdf"]
    urdf = _read_text(urdf_path)
    try:
        joints = read_chain(urdf, settings["end_effector"])
    except UsageError as error:
        raise UsageError(f"{urdf_path}: {error}") from error

    driven = [joint for joint in joints if joint.kind != "fixed"]
    home, max_speed, max_acceleration = (_read_joint_values(path, settings, key, len(driven)) for key in JOINT_KEYS)
    robot = Robot(
        name=settings["name"],
        urdf=urdf,
        folder=folder,
        end_effector_link=settings["end_effector"],
        joint_names=tuple(joint.name for joint in driven),
        lower=_read_only([-math.pi if joint.kind == "continuous" else joint.lower for joint in driven]),
        upper=_read_only([math.pi if joint.kind == "continuous" else joint.upper for joint in driven]),
        max_speed=max_speed,
        max_acceleration=max_acceleration,
        home=home,
        chain=build_chain(joints),
    )
    _check_joints_turn(urdf_path, driven)
    _check_home(path, robot)
    _check_positive(path, robot)
    _check_speed(path, robot, driven)
    return robot


def _read_settings(path: Path) -> dict[str, Any]:
    """The contents of a robot.toml: exactly the keys in KEYS, text where text belongs."""
    try:
        settings = tomllib.loads(_read_text(path))
    except tomllib.TOMLDecodeError as error:
        raise UsageError(f"{path}: not well-formed TOML ({error}). Correct it at that place.") from error
    for what, keys in (("unknown", settings.keys() - set(KEYS)), ("missing", set(KEYS) - settings.keys())):
        if keys:
            raise UsageError(f"{path}: {what} {', '.join(sorted(keys))}. Give exactly the keys {', '.join(KEYS)}.")
    for key in TEXT_KEYS:
        if not isinstance(settings[key], str) or not settings[key]:
            raise UsageError(f"{path}: {key} is {settings[key]!r}. Give a text that is not empty, in quotes.")
    return settings


def _read_text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise UsageError(f"{path}: cannot be read ({error.strerror}). A robot is a robot.toml and its URDF.") from error
    except UnicodeDecodeError as error:
        raise UsageError(f"{path}: is not UTF-8 text ({error.reason}). Save it as UTF-8.") from error


def _read_joint_values(path: Path, settings: dict[str, Any], key: str, dof: int) -> Array:
    """One value per driven joint, degrees turned into radians, read-only, shape (dof,)."""
    values = settings[key]
    if not isinstance(values, list) or not all(_is_finite_number(value) for value in values):
        raise UsageError(f"{path}: {key} is {values!r}. Give a list of {dof} finite numbers, one per driven joint.")
    if len(values) != dof:
        raise UsageError(f"{path}: {key} has {len(values)} values for {dof} driven joints. Give one per joint.")
    return _read_only([math.radians(value) for value in values])


def _is_finite_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _check_joints_turn(path: Path, driven: Sequence[Joint]) -> None:
    for joint in driven:
        if joint.kind == "prismatic":
            raise UsageError(f"{path}: driven joint '{joint.name}' is prismatic. A robot's joints turn: make it fixed.")


def _check_home(path: Path, robot: Robot) -> None:
    for name, low, home, high in zip(robot.joint_names, robot.lower, robot.home, robot.upper, strict=True):
        if not low <= home <= high:
            allowed = f"{math.degrees(low):g} to {math.degrees(high):g}"
            raise UsageError(f"{path}: home_deg of '{name}' is {math.degrees(home):g}; allowed: {allowed}. Correct it.")


def _check_positive(path: Path, robot: Robot) -> None:
    for key, values in (("max_speed_deg_s", robot.max_speed), ("max_acceleration_deg_s2", robot.max_acceleration)):
        for name, value in zip(robot.joint_names, values, strict=True):
            if value <= 0.0:
                raise UsageError(f"{path}: {key} of '{name}' is {math.degrees(value):g}. Give a positive value.")


def _check_speed(path: Path, robot: Robot, driven: Sequence[Joint]) -> None:
    """Raises where robot.toml allows more than the URDF; equal up to rounding is fine."""
    for joint, speed in zip(driven, robot.max_speed, strict=True):
        if joint.velocity is not None and speed > joint.velocity * (1.0 + 1e-6):
            given, allowed = math.degrees(speed), math.degrees(joint.velocity)
            raise UsageError(f"{path}: max_speed_deg_s of '{joint.name}' is {given:g}; the URDF allows {allowed:g}.")


def _read_only(values: Sequence[float]) -> Array:
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array
