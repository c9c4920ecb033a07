"""One robot arm: its URDF, and the few numbers beside it in `robot.toml` that a URDF has no place for."""

import hashlib
import math
import os
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import ArrayLike

from harness.arrays import Float
from harness.errors import UsageError
from harness.files.bounded import digest_of, reading
from harness.registry.choice import Registry
from harness.registry.registry import load_registry
from harness.registry.spec import did_you_mean
from harness.robot.chain_end import find_chain_end, find_jaw
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
from harness.robot.normal_urdf import fix_joint, named, normal_urdf
from harness.robot.packages import is_installed
from harness.robot.settings import (
    BASE,
    CHAIN,
    FILE,
    FIXED,
    JOINT_KEYS,
    RANGE_KEYS,
    TOOL,
    RobotSettings,
    motion_of,
    shown,
)
from harness.robot.shapes import Shape, attach_shapes, find_too_long, read_shapes
from harness.robot.source import naming, read_source
from harness.robot.urdf import (
    WORLD,
    Joint,
    Urdf,
    free_name,
    linked,
    number_of,
    parse_urdf,
    path_to,
    quoted,
    read_chain,
    rename_world,
    require_link,
)
from harness.text import shortened

END = "end_effector"
KEYS = {FIXED, CHAIN, TOOL, BASE, *RANGE_KEYS.values()}
"""Those that change anything."""
POSE = ("xyz_m", "rpy_deg")
NAME = "name"
TOOL_LINK = "tool"
"""What a tool's frame without a name is called."""
SHOWN = 100


class Mover(NamedTuple):
    """A joint that moves, before its numbers are read."""

    name: str
    kind: str


def arrange(given: Urdf, settings: RobotSettings, path: Path, frame: str | None = None) -> tuple[Urdf, str]:
    """The arm as robot.toml wants it.

    Args:
        given: What a file describes; it is left as it is.
        settings: The robot.toml.
        path: Of the file, which an error of it begins with.
        frame: The link that its author calls the tool's frame, if there is one.

    Returns:
        A URDF, `given` itself where robot.toml has none of the keys; and the link that is the end effector.

    Raises:
        UsageError: A key names no link or joint, or a number cannot be; the message begins with the file to correct.
    """
    if not KEYS & settings.entries.keys():
        return given, _find_end(given, settings, path, frame)
    urdf = Urdf("", deepcopy(given.element))
    _hold(urdf, settings, path)
    tip = _begin_and_end(urdf, settings, path) or _find_end(urdf, settings, path, frame)
    _limit(urdf, tip, settings)
    tip = _add_tool(urdf, tip, settings)
    _add_base(urdf, settings)
    return Urdf(ElementTree.tostring(urdf.element, encoding="unicode"), urdf.element), tip


def _find_end(urdf: Urdf, settings: RobotSettings, path: Path, frame: str | None) -> str:
    """The link that robot.toml names, else the tool's frame, else the end of the chain; raises where arms branch."""
    with naming(path):
        tip = settings.text(END)
        if tip is None:
            end = find_chain_end(urdf)
            tip = frame or end
        require_link(urdf, tip)
    return tip


def _hold(urdf: Urdf, settings: RobotSettings, path: Path) -> None:
    """Fix the joints of `fixed` at its values, and those that mimic them where that puts them."""
    given = settings.entries.get(FIXED, {})
    if not isinstance(given, dict):
        raise UsageError(
            f"{settings.place}: {FIXED} is {_shown(given)}. Give a table of joints by name, {{ joint = 0 }}."
        )
    moving = {_name(joint): joint for joint in urdf.joints if joint.get("type") != "fixed"}
    unknown = [name for name in given if name not in moving]
    if unknown:
        raise UsageError(
            f"{settings.place}: {FIXED} names '{shortened(unknown[0], SHOWN)}'.{did_you_mean(unknown[0], moving)} "
            f"Joints that move: {quoted(moving) or 'none'}."
        )
    positions = {name: _position(settings, moving[name], value) for name, value in given.items()}
    with naming(path):
        for name, joint in moving.items():
            position = positions[name] if name in positions else _mimicked(joint, positions)
            if position is not None:
                fix_joint(joint, position)


def _position(settings: RobotSettings, joint: Element, value: object) -> float:
    """Where a joint is held, [rad] or [m]."""
    mover = Mover(_name(joint), joint.get("type", ""))
    place, turns = f"{settings.place}: {FIXED} of '{mover.name}'", motion_of(mover) == "turning"
    if not isinstance(value, int | float) or isinstance(value, bool) or math.isnan(number_of(repr(value))):
        raise UsageError(f"{place} is {_shown(value)}. Give a number of {'degrees' if turns else 'metres'}.")
    if mover.kind in {"planar", "floating"} and value:
        raise UsageError(f"{place} is {value:g}, and the joint is {mover.kind}: such a joint can be held at 0 only.")
    position, limit = math.radians(value) if turns else float(value), joint.find("limit")
    lower, upper = (number_of("0" if limit is None else limit.get(end, "0")) for end in ("lower", "upper"))
    if mover.kind in {"revolute", "prismatic"} and lower < upper and not lower - 1e-9 <= position <= upper + 1e-9:
        allowed = f"{shown(lower, mover)} to {shown(upper, mover)} {'deg' if turns else 'm'}"
        raise UsageError(f"{place} is {value:g}; allowed: {allowed}, its range in the URDF. Correct it.")
    return position


def _mimicked(joint: Element, positions: Mapping[str, float]) -> float | None:
    """Where a joint is that mimics a held one; None of another."""
    mimic = joint.find("mimic")
    if mimic is None or (leader := mimic.get("joint", "")) not in positions:
        return None
    factor, offset = number_of(mimic.get("multiplier", "1")), number_of(mimic.get("offset", "0"))
    position = factor * positions[leader] + offset
    return None if math.isnan(position) else position


def _begin_and_end(urdf: Urdf, settings: RobotSettings, path: Path) -> str | None:
    """The last link of `chain`, None where it is left out; joints before the first link are fixed at rest."""
    names = settings.texts(CHAIN, 2)
    if names is None:
        return None
    first, last = _link_at(urdf, settings, names[0], "parent"), _link_at(urdf, settings, names[1], "child")
    if settings.text(END) not in {None, last}:
        raise UsageError(f"{settings.place}: {CHAIN} ends at '{last}', {END} is '{settings.text(END)}'. Keep one.")
    if first not in [linked(joint, "parent") for joint in path_to(last, urdf.carriers)]:
        raise UsageError(f"{settings.place}: {CHAIN} begins at '{first}', which does not carry '{last}'. Correct it.")
    with naming(path):
        for joint in path_to(first, urdf.carriers):
            if joint.get("type") != "fixed":
                fix_joint(joint)
    return last


def _link_at(urdf: Urdf, settings: RobotSettings, name: str, end: Any) -> str:
    """The link of a name, or at one end of the joint of that name."""
    if name in urdf.links:
        return name
    joints = {_name(joint): joint for joint in urdf.joints}
    if name in joints:
        return linked(joints[name], end)
    raise UsageError(
        f"{settings.place}: {CHAIN} names '{shortened(name, SHOWN)}', no link or joint."
        f"{did_you_mean(name, {*urdf.links, *joints})} The links: {quoted(urdf.links)}."
    )


def _limit(urdf: Urdf, tip: str, settings: RobotSettings) -> None:
    """Write the ranges of `range_deg` and `range_m` into the joints; a continuous one then has ends."""
    moving = [joint for joint in path_to(tip, urdf.carriers) if joint.get("type") != "fixed"]
    ranges = settings.ranges([Mover(_name(joint), joint.get("type", "")) for joint in moving])
    for joint, given in zip(moving, ranges, strict=True):
        if given is not None:
            limit = joint.find("limit")
            limit = ElementTree.SubElement(joint, "limit") if limit is None else limit
            limit.attrib.update(lower=repr(given[0]), upper=repr(given[1]))
            joint.set("type", "revolute" if joint.get("type") == "continuous" else joint.get("type", ""))


def _add_tool(urdf: Urdf, tip: str, settings: RobotSettings) -> str:
    """Fix the frame of `tool` to the end effector's link; the new end effector's link."""
    table = settings.table(TOOL, (*POSE, NAME))
    if table is None:
        return tip
    name = table.entries.get(NAME, TOOL_LINK)
    if not isinstance(name, str) or name in {"", WORLD}:
        raise UsageError(f"{table.place}: {NAME} is {_shown(name)}. Give another, in quotes.")
    if name in urdf.links:
        raise UsageError(f"{table.place}: {NAME} is {_shown(name)}, a link of the URDF. Give another.")
    urdf.element.append(Element("link", name=name))
    urdf.element.append(_mount(urdf, table, tip, name))
    return name


def _add_base(urdf: Urdf, settings: RobotSettings) -> None:
    """Fix the root link to a new one, the world, at the pose of `base`."""
    table = settings.table(BASE, POSE)
    if table is None:
        return
    root = next(name for name in urdf.links if name not in urdf.carriers)
    if root == WORLD:
        root = rename_world(urdf.element)
    urdf.element.insert(0, Element("link", name=WORLD))
    urdf.element.append(_mount(urdf, table, WORLD, root))


def _mount(urdf: Urdf, table: RobotSettings, parent: str, child: str) -> Element:
    """A fixed joint with the pose of a table."""
    joint = Element("joint", name=free_name(f"{parent}_to_{child}", map(_name, urdf.joints)), type="fixed")
    ElementTree.SubElement(joint, "parent", link=parent)
    ElementTree.SubElement(joint, "child", link=child)
    xyz, rpy = table.vector(POSE[0]), map(math.radians, table.vector(POSE[1]))
    ElementTree.SubElement(joint, "origin", xyz=" ".join(map(repr, xyz)), rpy=" ".join(map(repr, rpy)))
    return joint


def _name(joint: Element) -> str:
    return joint.get("name", "")


def _shown(given: object) -> str:
    return shortened(repr(given), SHOWN)


FEWEST_JOINTS, MOST_JOINTS = 3, 8
SUFFIXES = (".urdf", ".xacro", ".xml", FILE)
"""Endings of the files that describe robots; the name of no plugin has one."""
FD100_REACH = 1.5413267497929588
"""Reach of the FD100, [m]."""


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

    @cached_property
    def scale(self) -> float:
        """The reach as a share of the FD100's, for whose reach the lengths of tasks and motions were chosen."""
        return self.reach / FD100_REACH

    @cached_property
    def base_shapes(self) -> tuple[Shape, ...]:
        """The collision shapes that no joint moves, in the world's frame."""
        return attach_shapes(parse_urdf(self.urdf), self.link_shapes, (None,))[0]

    def scaled(self, length: float) -> float:
        """A length or speed of the tip that was chosen for the FD100, as large a share of this arm's reach.

        Args:
            length: [m] or [m/s].

        Returns:
            In the same unit, with three digits: it is to be read, and the same on all platforms. For the FD100, or an
            arm of its reach, the number itself.
        """
        return length if math.isclose(self.scale, 1.0, rel_tol=1e-6) else float(f"{self.scale * length:.3g}")

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
        source = read_source(path, registry)
        settings, described = source.settings, source.described
        urdf_path = Path(settings.installed or source.path)
        with naming(urdf_path):
            parsed = parse_urdf(described.urdf)
        given, tip = arrange(parsed, settings, urdf_path, described.tip)
        packages = settings.folders()
        with naming(urdf_path):
            joints = read_chain(given, tip)
            driven = [joint for joint in joints if joint.kind != "fixed"]
            if not FEWEST_JOINTS <= len(driven) <= MOST_JOINTS:
                remedy = f"Name another end_effector in a {FILE}, or give another arm"
                if len(driven) > MOST_JOINTS:
                    held = "hold some: fixed = { joint = 0 }"
                    remedy = f"In a {FILE}, {held}; or name where the arm lies: chain = [first, last]"
                told = f"{len(driven)} joints move between the root link and '{tip}'"
                raise UsageError(f"{told}; allowed: {FEWEST_JOINTS} to {MOST_JOINTS}. {remedy}.")
            names = tuple(joint.name for joint in driven)
            urdf, changes = normal_urdf(given, names, source.path.parent, packages)
            link_shapes = read_shapes(urdf)
            joint_shapes = attach_shapes(urdf, link_shapes, names)
            chain = build_chain(joints)
            long = _warn_of_length(urdf, chain, driven)
        limits = read_joint_limits(settings, urdf_path, driven, chain, joint_shapes, described.home)
        return Robot(
            name=settings.text("name") or urdf_path.stem.removesuffix(".urdf"),
            urdf=urdf.text,
            folder=source.path.parent,
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
                *described.warnings,
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
