"""A URDF with nothing left to guess: what every simulator reads, so that all of them read the same arm."""

import math
from collections.abc import Collection, Mapping
from copy import deepcopy
from pathlib import Path
from types import MappingProxyType
from typing import cast
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from harness.arrays import Float
from harness.errors import UsageError
from harness.robot.kinematics import build_chain, forward
from harness.robot.meshes import locate_mesh
from harness.robot.urdf import LARGEST, Joint, JointKind, Urdf, linked, number_of, read_axis, read_vector

NEXT_TO_NO_MASS = ElementTree.fromstring("""<inertial><mass value="1e-6"/>
<inertia ixx="1e-9" iyy="1e-9" izz="1e-9" ixy="0" ixz="0" iyz="0"/></inertial>""")
"""The inertia of a link without mass, in kg and kg m^2. Engines would take 1 kg, a solid of water, or a part of the
ground."""
MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
SMALLEST_MOMENT = 1e-9
"""[kg m^2]."""
ROUNDING = 1e-3
"""The rounding of the moments in a URDF, as a share of them."""
UNUSED = ("limit", "dynamics", "safety_controller", "calibration")
"""Parts of a joint with numbers that nothing uses, or that were read before: a word in place of one stops engines."""
MOST_SHAPES = 1_000
"""Collisions and visuals of all links together: a hundred for each link of an arm."""
MOST_MESH_BYTES = 512 * 2**20
"""The most bytes of the files of all of these together, each as often as it is named."""


def normal_urdf(
    urdf: Urdf, driven: Collection[str], folder: Path, packages: Mapping[str, Path] = MappingProxyType({})
) -> Urdf:
    """The same arm with its meshes found, its other joints fixed and a mass for every link.

    Joints that are not driven are fixed at zero, or at the end of their range that is nearest to it. Meshes have
    absolute paths. Words in the place of numbers that nothing uses are left out. Links without mass or inertia get
    next to none; an inertia that no body can have becomes a ball's.

    Args:
        urdf: The URDF; it is left as it is.
        driven: Names of the joints that move.
        folder: Where the names of meshes start.
        packages: Where those of packages lead, see `harness.robot.meshes.locate_mesh`.

    Returns:
        A URDF; `urdf` itself where there was nothing to do.

    Raises:
        UsageError: A mesh is not there, a joint to be fixed cannot be computed with, or there are too many shapes.
    """
    _require_few_shapes(urdf)
    robot = deepcopy(urdf.element)
    for joint in robot.findall("joint"):
        if joint.get("name") not in driven and joint.get("type") != "fixed":
            fix_joint(joint)
        _drop_words(joint)
    size = 0
    for link in robot.findall("link"):
        _give_mass(link)
        size += _locate_meshes(link, folder, packages)
    if size > MOST_MESH_BYTES:
        raise UsageError(f"The meshes have {size:,} bytes together, {MOST_MESH_BYTES:,} are allowed. Simplify them.")
    return urdf if _are_alike(robot, urdf.element) else Urdf(ElementTree.tostring(robot, encoding="unicode"), robot)


def _are_alike(first: Element, second: Element) -> bool:
    """Whether two elements say the same; to compare their texts, which have to be written first, takes much longer."""
    own, other = ((each.tag, each.attrib, each.text, each.tail, len(each)) for each in (first, second))
    return own == other and all(map(_are_alike, first, second))


def fix_joint(joint: Element, held: float | None = None) -> None:
    """Turn a joint that moves into a fixed one.

    Args:
        joint: It is changed.
        held: Its position, [rad] or [m]; of a planar or floating one 0. None for zero, or as near to it as its range
            allows.

    Raises:
        UsageError: Its origin or axis cannot be computed with.
    """
    pose = _pose_of(joint, held)
    kept = {"parent", "child"}
    for part in [part for part in joint if part.tag not in kept]:
        joint.remove(part)
    joint.set("type", "fixed")
    origin = {"xyz": _text(pose[:3, 3]), "rpy": _text(_rpy_from_rotation(pose[:3, :3]))}
    joint.append(Element("origin", origin))


def _drop_words(joint: Element) -> None:
    """Leave out what is no number in the parts that nothing uses, and a fixed joint's axis if it has such."""
    for part in [part for part in joint if part.tag in UNUSED]:
        words = [name for name, text in part.items() if not _is_number(text)]
        for name in words:
            del part.attrib[name]
        if words and not part.attrib:
            joint.remove(part)
    if joint.get("type") == "fixed":
        for axis in joint.findall("axis"):
            if not all(map(_is_number, axis.get("xyz", "").split())):
                joint.remove(axis)


def _is_number(text: str) -> bool:
    """Whether an engine can read a text as a number, be it an infinity."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def _pose_of(joint: Element, held: float | None) -> Float:
    """T_parent_child, (4, 4); arguments as for `fix_joint`."""
    xyz = read_vector(joint, "origin", "xyz", default=(0.0, 0.0, 0.0))
    rpy = read_vector(joint, "origin", "rpy", default=(0.0, 0.0, 0.0))
    names = joint.get("name", ""), linked(joint, "parent"), linked(joint, "child")
    name, parent, child = names
    kind, position, axis = joint.get("type"), held or 0.0, (1.0, 0.0, 0.0)
    if held is None and kind in {"revolute", "prismatic"}:
        position = _position_at_rest(joint)
    if position:
        axis = read_axis(joint)
    else:
        kind = "continuous"  # at zero they all are alike
    moved = Joint(name, cast(JointKind, kind), parent, child, xyz, rpy, axis, 0.0, 0.0, None)
    return forward(build_chain([moved]), [position])


def _position_at_rest(joint: Element) -> float:
    """The number of its range that is nearest to 0; 0 where it names no range."""
    limit = joint.find("limit")
    lower, upper = (number_of("0" if limit is None else limit.get(end, "0")) for end in ("lower", "upper"))
    return max(lower, min(upper, 0.0)) if lower <= upper else 0.0


def _rpy_from_rotation(rotation: Float) -> Float:
    """Turns about the fixed x, then y, then z axis, (3,), [rad]; at a pitch of 90 degrees the yaw is 0."""
    pitch = np.arctan2(-rotation[2, 0], np.hypot(rotation[0, 0], rotation[1, 0]))
    if np.hypot(rotation[0, 0], rotation[1, 0]) < 1e-9:
        return np.array([np.arctan2(-rotation[1, 2], rotation[1, 1]), pitch, 0.0])
    roll = np.arctan2(rotation[2, 1], rotation[2, 2])
    return np.array([roll, pitch, np.arctan2(rotation[1, 0], rotation[0, 0])])


def _text(numbers: Float) -> str:
    return " ".join(repr(float(number)) for number in numbers)


def _give_mass(link: Element) -> None:
    """Give a link a mass and an inertia that a body can have, where it has none."""
    inertial = link.find("inertial")
    if inertial is None or inertial.find("inertia") is None or _number(link, inertial, "mass", "value") <= 0.0:
        for part in link.findall("inertial"):
            link.remove(part)
        link.append(deepcopy(NEXT_TO_NO_MASS))
        return
    moments = {name: _number(link, inertial, "inertia", name) for name in MOMENTS}
    balanced = _balance(np.array([moments[name] for name in MOMENTS]))
    if balanced is not None:
        for name, moment in zip(MOMENTS, balanced, strict=True):
            cast(Element, inertial.find("inertia")).set(name, repr(float(moment)))


def _balance(moments: Float) -> Float | None:
    """A ball's inertia instead of one that no body can have, in the order of `MOMENTS`; None where there is no need.

    No principal moment is larger than the two others together, and none is 0 or less.
    """
    ixx, iyy, izz, ixy, ixz, iyz = moments
    low, middle, high = np.linalg.eigvalsh([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    if low > 0.0 and high <= (low + middle) * (1.0 + ROUNDING):
        return None
    mean = max((ixx + iyy + izz) / 3.0, SMALLEST_MOMENT)
    return np.array([mean, mean, mean, 0.0, 0.0, 0.0])


def _number(link: Element, inertial: Element, tag: str, attribute: str) -> float:
    """An attribute of the inertial's element `tag`; 0 where it is missing."""
    part = inertial.find(tag)
    text = "0" if part is None else part.get(attribute, "0")
    number = number_of(text)
    if math.isnan(number):
        given = f"Link '{link.get('name')}' has '{text}' in <{tag} {attribute}=...>"
        raise UsageError(f"{given}. Give a finite number of at most {LARGEST:g}.")
    return number


def _require_few_shapes(urdf: Urdf) -> None:
    count = sum(len(link.findall(tag)) for link in urdf.links.values() for tag in ("collision", "visual"))
    if count > MOST_SHAPES:
        raise UsageError(f"The URDF has {count:,} shapes, {MOST_SHAPES:,} are allowed. Simplify it.")


def _locate_meshes(link: Element, folder: Path, packages: Mapping[str, Path]) -> int:
    """Writes where the link's meshes are; how many bytes they have."""
    total = 0
    for mesh in link.iter("mesh"):
        try:
            path = locate_mesh(mesh.get("filename", ""), folder, packages)
        except UsageError as error:
            raise UsageError(f"Link '{link.get('name')}' {error}") from error
        mesh.set("filename", str(path))
        total += path.stat().st_size
    return total
