"""One robot arm: its URDF, and the few numbers beside it in `robot.toml` that a URDF has no place for."""

import hashlib
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import ArrayLike

from harness.arrays import Float
from harness.errors import UsageError
from harness.files.bounded import digest_of, reading
from harness.registry.registry import Registry, load_registry
from harness.robot.arrangement import arrange
from harness.robot.chain_end import find_jaw
from harness.robot.description import Description
from harness.robot.joint_limits import RULES, Servo, describe_origin, read_joint_limits, read_servo, warn_of_speeds
from harness.robot.kinematics import (
    Chain,
    build_chain,
    chain_length,
    end_effector_position,
    position_jacobian,
    read_only,
)
from harness.robot.meshes import SCENES
from harness.robot.normal_urdf import named, normal_urdf
from harness.robot.packages import is_installed
from harness.robot.settings import CHAIN, FILE, JOINT_KEYS, TOOL, RobotSettings
from harness.robot.shapes import Shape, attach_shapes, find_too_long, read_shapes
from harness.robot.source import naming, read_source
from harness.robot.urdf import Joint, Urdf, parse_urdf, read_chain

FEWEST_JOINTS, MOST_JOINTS = 3, 8
SUFFIXES = (".urdf", ".xacro", ".xml", FILE)
"""Endings of the files that describe robots; the name of no plugin has one."""
FD100_REACH = 1.5413267497929588
"""Reach of the FD100, [m]. Lengths of tasks and motions were chosen for it."""


@dataclass(frozen=True, eq=False)
class Robot:
    """One arm with `dof` joints that turn or slide, standing on the world's origin.

    All arrays are read-only, and float64 of shape (dof,) where nothing else is said, in the order of the chain from
    the root link. Where a joint slides, read m for rad.

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
        link_shapes: The collision shapes of each link of `urdf`, in the link's frame, by the link's name.
        joint_shapes: The same shapes by the driven joint that moves them, in the frame of its child link; dof entries.
        origins: Where the end effector, home, speeds and accelerations come from, in words.
        servo: The drives of the joints; None where robot.toml has no `[servo]`.
        warnings: What to know before anything is trained, a line each.
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
    link_shapes: Mapping[str, tuple[Shape, ...]] = field(repr=False)
    joint_shapes: tuple[tuple[Shape, ...], ...] = field(repr=False)
    origins: Mapping[str, str] = field(repr=False)
    servo: Servo | None = field(default=None, repr=False)
    warnings: tuple[str, ...] = field(default=(), repr=False)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of all that decides how the arm moves: the URDF, the meshes' content, and the numbers beside it.

        The drives, `servo`, do not count: most simulators move the arm without them. Nor does where the files lie: a
        copy of the robot in another folder has the same digest.

        Raises:
            OSError: A mesh is gone.
        """
        numbers = np.stack([self.lower, self.upper, self.max_speed, self.max_acceleration, self.home])
        parts = (_name_meshes_by_content(self.urdf).encode(), self.end_effector_link.encode(), numbers.tobytes())
        return hashlib.sha256(b"\0".join(parts)).hexdigest()

    @cached_property
    def driven_digest(self) -> str:
        """The same with the drives: SHA-256 of all that decides how the arm moves where they are simulated.

        Raises:
            OSError: A mesh is gone.
        """
        if self.servo is None:
            return self.digest
        return hashlib.sha256(f"{self.digest} {self.servo.digest}".encode()).hexdigest()

    @cached_property
    def dof(self) -> int:
        """Number of driven joints."""
        return self.chain.dof

    @cached_property
    def per_radian(self) -> Float:
        """What counts as much as 1 rad of each joint, (dof,): where it turns 1; where it slides its range by 2 pi, [m].

        So the whole range of a slide counts as a full turn, and 6 degrees are a sixtieth of it.
        """
        return read_only(np.where(self.chain.slides, (self.upper - self.lower) / (2.0 * math.pi), 1.0))

    @cached_property
    def reach(self) -> float:
        """No end effector position is farther than this from the first joint's origin: the chain stretched out [m]."""
        return chain_length(self.chain, self.lower, self.upper)

    @cached_property
    def extent(self) -> float:
        """No end effector position is farther than this from the world's origin: the chain's begin and `reach` [m]."""
        return self.reach + float(np.linalg.norm(self.chain.T_previous_joint[0, :3, 3]))

    def scaled(self, length: float) -> float:
        """A length or speed of the tip that was chosen for the FD100, as large a share of this arm's reach.

        Args:
            length: [m] or [m/s].

        Returns:
            In the same unit, with three digits: it is to be read, and the same on all platforms. For the FD100, or an
            arm of its reach, the number itself.
        """
        scale = self.reach / FD100_REACH
        return length if math.isclose(scale, 1.0, rel_tol=1e-6) else float(f"{scale * length:.3g}")

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


def read_robot(path: Path, registry: Registry | None = None) -> Robot:
    """The robot of a folder or a URDF, or of a file that a plugin makes a URDF of.

    Args:
        path: A folder whose `robot.toml` names the URDF, or that file; or a URDF, beside which a `robot.toml` may lie
            that names it or none. Of one that names another URDF nothing is taken. Also ``PACKAGE:PATH`` of an
            installed package.
        registry: Has the readers of what is no URDF; loaded if None, and only where it is needed.

    Returns:
        The robot, every number checked.

    Raises:
        UsageError: A file cannot be read or says something that cannot be; the message names the file.
    """
    with reading(path, "robot", UsageError):
        return _read_robot(path, registry)


def _read_robot(path: Path, registry: Registry | None) -> Robot:
    source = read_source(path, registry)
    settings, described = source.settings, source.described
    urdf_path = Path(settings.installed or source.path)
    with naming(urdf_path):
        parsed = parse_urdf(source.text)
    given, tip = arrange(parsed, settings, urdf_path, described.tip)
    packages = settings.folders()
    with naming(urdf_path):
        joints = read_chain(given, tip)
        driven = [joint for joint in joints if joint.kind != "fixed"]
        _check_count(driven, tip)
        names = tuple(joint.name for joint in driven)
        urdf, changes = normal_urdf(given, names, source.folder, packages)
        link_shapes = read_shapes(urdf)
        joint_shapes = attach_shapes(urdf, link_shapes, names)
        chain = build_chain(joints)
        long = _warn_of_length(urdf, chain, driven)
    limits = read_joint_limits(settings, urdf_path, driven, chain, joint_shapes, described.home)
    return Robot(
        name=settings.text("name") or urdf_path.stem.removesuffix(".urdf"),
        urdf=urdf.text,
        folder=source.folder,
        end_effector_link=tip,
        joint_names=names,
        lower=limits.lower,
        upper=limits.upper,
        max_speed=limits.max_speed,
        max_acceleration=limits.max_acceleration,
        home=limits.home,
        chain=chain,
        link_shapes=link_shapes,
        joint_shapes=joint_shapes,
        origins=_origins(settings, driven, described),
        servo=read_servo(settings, driven),
        warnings=(
            *source.warnings,
            *changes,
            *long,
            *warn_of_speeds(driven, limits.max_speed),
            *([described.speeds] if described.speeds and None in settings.values("max_speed", driven) else []),
            *_warn_of_jaw(settings, given, joints),
        ),
    )


def _warn_of_length(urdf: Urdf, chain: Chain, driven: Sequence[Joint]) -> list[str]:
    reach = chain_length(chain, *np.array([[joint.lower, joint.upper] for joint in driven]).T)
    long = find_too_long(urdf, reach)
    if not long:
        return []
    given = f"{named(long)}: a mesh {max(long.values()):.3g} m long, and the arm reaches {reach:.3g} m"
    return [f'{given}. If the file is in millimetres, give the <mesh> scale="0.001 0.001 0.001"']


def _warn_of_jaw(settings: RobotSettings, urdf: Urdf, joints: Sequence[Joint]) -> list[str]:
    is_named = {"end_effector", CHAIN} & settings.entries.keys()
    own = joints[:-1] if TOOL in settings.entries else joints  # a tool is fixed to what the URDF alone ends at
    jaw = None if is_named else find_jaw(urdf, build_chain(own), own)
    return [] if jaw is None else [jaw.warning(settings.to_write)]


def _check_count(driven: Sequence[Joint], tip: str) -> None:
    if not FEWEST_JOINTS <= len(driven) <= MOST_JOINTS:
        to_do = f"In a {FILE}, hold some: fixed = {{ joint = 0 }}; or name where the arm lies: chain = [first, last]."
        raise UsageError(
            f"{len(driven)} joints move between the root link and '{tip}'; allowed: {FEWEST_JOINTS} to {MOST_JOINTS}. "
            f"{to_do if len(driven) > MOST_JOINTS else f'Name another end_effector in a {FILE}, or give another arm.'}"
        )


def _name_meshes_by_content(urdf: str) -> str:
    """The URDF's text with the SHA-256 of each mesh file in the place of its path; a URDF without meshes as it is.

    Drawings that only `SCENES` names are left out: whether they are in the URDF depends on what is installed.
    """
    if "mesh" not in urdf:
        return urdf
    robot = parse_urdf(urdf).element
    for link in robot.iter("link"):
        for visual in link.findall("visual"):
            if any(_path(mesh).suffix.lower() in SCENES for mesh in visual.iter("mesh")):
                link.remove(visual)
    for mesh in robot.iter("mesh"):
        mesh.set("filename", digest_of(_path(mesh)) + _path(mesh).suffix.lower())
    return ElementTree.tostring(robot, encoding="unicode")


def _path(mesh: Element) -> Path:
    return Path(mesh.get("filename", ""))


def _origins(settings: RobotSettings, driven: Sequence[Joint], described: Description) -> Mapping[str, str]:
    is_named = {"end_effector", CHAIN, TOOL} & settings.entries.keys()
    tip = FILE if is_named else "the frame of its tool" if described.tip else "the end of the chain"
    origins = {"end_effector": tip} | {each: describe_origin(settings, each, driven) for each in JOINT_KEYS}
    if described.home and origins["home"] == RULES["home"]:
        origins["home"] = described.home_origin
    return origins


def load_robot(name_or_path: str | Path, registry: Registry | None = None) -> Robot:
    """A registered robot, or the one that a path leads to.

    Args:
        name_or_path: ``fd100``; or a path as `read_robot` takes it, be it the bare name of a folder.
        registry: The plugins; loaded if None.

    Raises:
        UsageError: No such robot, or its files say something that cannot be.
    """
    text = str(name_or_path)
    if is_path(name_or_path) and (os.path.exists(text) or is_installed(text)):  # no error, whatever the text
        return read_robot(Path(text), registry)
    plugins = registry or load_registry()
    is_name = "robots" in plugins.kinds_of(text)  # a qualified name looks like a path
    if is_folder(text) and not is_name:
        return read_robot(Path(text), plugins)
    if is_path(name_or_path) and not is_name:
        raise UsageError(f"No robot at '{text}': name a URDF, a folder that holds robot.toml, or a registered robot")
    folder: Path = plugins.get("robots", text).load()
    return read_robot(folder, registry)


def is_folder(robot: str) -> bool:
    """Whether a text leads to a folder with a robot.toml; one in the working directory has a name without a slash."""
    return os.path.isfile(os.path.join(robot, FILE))


def is_path(robot: str | Path) -> bool:
    """Whether a robot is given by the path of its files, and not by a registered name."""
    text = str(robot)
    return isinstance(robot, Path) or "/" in text or "\\" in text or text.endswith(SUFFIXES)
