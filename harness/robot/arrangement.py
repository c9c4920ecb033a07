"""What `robot.toml` changes of the arm that a URDF describes, as the same URDF with other joints.

The mount it stands on, joints that are held, where it begins and ends, its tool, and ranges of its joints.
"""

import math
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from harness.errors import UsageError
from harness.registry.spec import did_you_mean
from harness.robot.chain_end import find_chain_end
from harness.robot.normal_urdf import fix_joint
from harness.robot.settings import BASE, CHAIN, FIXED, RANGE_KEYS, TOOL, RobotSettings, motion_of, shown
from harness.robot.source import naming
from harness.robot.urdf import WORLD, Urdf, free_name, linked, number_of, path_to, quoted, rename_world, require_link
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
