"""A URDF with nothing left to guess: what every simulator reads, so that all of them read the same arm."""

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple, cast
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from harness.arrays import Float
from harness.errors import UsageError
from harness.robot.kinematics import build_chain, forward
from harness.robot.meshes import TO_READ_THEM, locate_mesh, needs_extra, read_mesh
from harness.robot.shapes import moving_carrier, read_origin, read_points, read_scale
from harness.robot.urdf import LARGEST, Joint, JointKind, Urdf, linked, number_of, read_axis, read_vector

NEXT_TO_NO_MASS = ElementTree.fromstring("""<inertial><mass value="1e-6"/>
<inertia ixx="1e-9" iyy="1e-9" izz="1e-9" ixy="0" ixz="0" iyz="0"/></inertial>""")
"""The inertia of a link without mass, in kg and kg m^2. Engines would take 1 kg, a solid of water, or a part of the
ground."""
MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
NO_MASS = 1e-6
"""The mass of a link without one, [kg]; what has no more is a frame of somebody's exporter."""
SMALLEST_MOMENT = 1e-9
"""[kg m^2]."""
LEAST_MOMENT = 1e-12
"""A principal moment that is no larger counts as 0, [kg m^2]: MuJoCo takes it for rounding."""
ROUNDING = 1e-3
"""The rounding of the moments in a URDF, as a share of them."""
UNUSED = ("limit", "dynamics", "safety_controller", "calibration")
"""Parts of a joint with numbers that nothing uses, or that were read before: a word in place of one stops engines."""
MOST_SHAPES = 1_000
"""Collisions and visuals of all links together: a hundred for each link of an arm."""
MOST_MESH_BYTES = 512 * 2**20
"""The most bytes of the files of all of these together, each as often as it is named."""
FEWEST_POINTS, SMALLEST_AREA = 4, 1e-12
"""The least points and surface of a drawing, [m^2]: MuJoCo takes no less."""
SHOWN = 3
"""Names in a warning."""


class NormalUrdf(NamedTuple):
    """An arm for every engine.

    Attributes:
        urdf: The URDF.
        warnings: What was changed that its owner should know, a line each.
    """

    urdf: Urdf
    warnings: tuple[str, ...]


def normal_urdf(
    urdf: Urdf, driven: Collection[str], folder: Path, packages: Mapping[str, Path] = MappingProxyType({})
) -> NormalUrdf:
    """The same arm with its meshes found, its other joints fixed and a mass for every link.

    Joints that are not driven are fixed at zero, or at the end of their range that is nearest to it. Meshes have
    absolute paths; drawings that cannot be read are left out, and so are collision meshes that stand still. Words in
    the place of numbers that nothing uses are left out. Links without mass or inertia get next to none; an inertia that
    no body can have becomes a ball's.

    Args:
        urdf: The URDF; it is left as it is.
        driven: Names of the joints that move.
        folder: Where the names of meshes start.
        packages: Where those of packages lead, see `harness.robot.meshes.locate_mesh`.

    Returns:
        A URDF, `urdf` itself where there was nothing to do; and warnings.

    Raises:
        UsageError: A mesh that moves and collides cannot be read, a joint to be fixed cannot be computed with, or there
            are too many shapes.
    """
    count = sum(len(link.findall(tag)) for link in urdf.links.values() for tag in ("collision", "visual"))
    if count > MOST_SHAPES:
        raise UsageError(f"The URDF has {count:,} shapes, {MOST_SHAPES:,} are allowed. Simplify it.")
    robot = deepcopy(urdf.element)
    for joint in robot.findall("joint"):
        if joint.get("name") not in driven and joint.get("type") != "fixed":
            fix_joint(joint)
        _drop_words(joint)
    _drop_colors(robot)
    if not robot.get("name"):
        robot.set("name", "robot")  # Bullet reads none without
    size, told = 0, _Told()
    find = partial(locate_mesh, folder=folder, packages=packages)
    carriers = Urdf("", robot).carriers
    movers = {name: moving_carrier(name, carriers)[0] for name in urdf.links}
    solid = {movers[name] for name, link in urdf.links.items() if _is_solid(link)}
    for link in robot.findall("link"):
        mover = movers[link.get("name", "")]
        _settle_inertia(link, mover is not None, mover in solid, told)
        size += _settle_meshes(link, mover is not None, find, told)
    if size > MOST_MESH_BYTES:
        raise UsageError(f"The meshes have {size:,} bytes together, {MOST_MESH_BYTES:,} are allowed. Simplify them.")
    is_same = _are_alike(robot, urdf.element)
    plain = urdf if is_same else Urdf(ElementTree.tostring(robot, encoding="unicode"), robot)
    return NormalUrdf(plain, tuple(told.lines()))


@dataclass(frozen=True)
class _Told:
    """What was changed that an owner should know.

    Attributes:
        massless: Links that move, have a shape, and have no mass, nor have those that are fixed to them.
        no_moment: Links that move and have a principal moment of inertia of `LEAST_MOMENT` or less.
        no_triangle: Links that move and have one that is larger than the two others together.
        unread: Formats of drawings that are left out, whose reader is not installed; each as often as there are some.
        undrawn: Why each other drawing is left out.
        untouched: Links that stand still whose collision meshes are left out, and why.
    """

    massless: list[str] = field(default_factory=list)
    no_moment: list[str] = field(default_factory=list)
    no_triangle: list[str] = field(default_factory=list)
    unread: list[str] = field(default_factory=list)
    undrawn: list[str] = field(default_factory=list)
    untouched: dict[str, str] = field(default_factory=dict)

    def lines(self) -> Iterator[str]:
        """At most one of each kind."""
        if count := len(self.unread) + len(self.undrawn):
            left = "1 drawing is left out" if count == 1 else f"{count} drawings are left out"
            yield f"{left}: {'; '.join(self._drawings())}"
        if self.untouched:
            reason = next(iter(self.untouched.values()))
            yield f"{named(self.untouched)} without collision meshes, which no joint of the chain moves: {reason}"
        if self.massless:
            yield f"{named(self.massless)} without mass or inertia: 1e-6 kg is taken. Give each its <inertial>"
        if self.no_moment or self.no_triangle:
            yield f"an inertia that no body has: {'; '.join(self._balls())}. A ball's with the same mean is taken"

    def _drawings(self) -> Iterator[str]:
        if self.unread:
            yield f"{', '.join(sorted(set(self.unread)))} ({TO_READ_THEM} has them read)"
        if self.undrawn:
            more = len(self.undrawn) - 1
            yield self.undrawn[0] + (f" {more} more cannot be read." if more else "")

    def _balls(self) -> Iterator[str]:
        if self.no_moment:
            yield f"{named(self.no_moment)} with a principal moment of 0 or less"
        if self.no_triangle:
            yield f"{named(self.no_triangle)} with one larger than the two others together"


def named(links: Collection[str]) -> str:
    """Links in a sentence: ``link 'a'``, or ``links 'a', 'b', 'c' and 2 more``."""
    shown = ", ".join(f"'{link}'" for link in list(links)[:SHOWN])
    return f"link{'s' * (len(links) > 1)} {shown}" + (f" and {len(links) - SHOWN} more" if len(links) > SHOWN else "")


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


def _drop_colors(robot: Element) -> None:
    """Leave out colours that are not four numbers."""
    for material in robot.iter("material"):
        for color in material.findall("color"):
            words = color.get("rgba", "").split()
            if len(words) != 4 or not all(map(_is_number, words)):
                material.remove(color)


def _is_number(text: str) -> bool:
    """Whether an engine can read a text as a number and compute with it, be it an infinity."""
    try:
        return not math.isnan(float(text))
    except ValueError:
        return False


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


def _read_inertia(link: Element) -> tuple[float, Float]:
    """A link's mass, [kg], and its moments in the order of `MOMENTS`, [kg m^2]; all 0 where it has no mass."""
    inertial = link.find("inertial")  # as in ROS, the first
    if inertial is None or inertial.find("inertia") is None or _number(link, inertial, "mass", "value") <= 0.0:
        return 0.0, np.zeros(len(MOMENTS))
    moments = [_number(link, inertial, "inertia", name) for name in MOMENTS]
    return _number(link, inertial, "mass", "value"), np.array(moments)


def _is_solid(link: Element) -> bool:
    """Whether a link has enough mass and inertia for others that are fixed to it."""
    mass, moments = _read_inertia(link)
    return mass > NO_MASS and float(moments[:3].sum()) > 0.0


def _settle_inertia(link: Element, moves: bool, is_on_solid: bool, told: _Told) -> None:
    """Give a link a mass and an inertia that a body can have, where it has none.

    Args:
        link: The link.
        moves: Whether a joint of the chain moves it.
        is_on_solid: Whether that joint moves a solid link: another one without mass then changes nothing.
        told: What to add to.
    """
    mass, moments = _read_inertia(link)
    for unread in link.findall("inertial")[int(mass > 0.0) :]:
        link.remove(unread)
    told_of = moves and (not is_on_solid or (mass > NO_MASS and bool(moments.any())))
    if mass <= 0.0:
        has_shape = any(link.find(part) is not None for part in ("collision", "visual"))
        link.append(deepcopy(NEXT_TO_NO_MASS))
        if told_of and has_shape:
            told.massless.append(link.get("name", ""))
        return
    ixx, iyy, izz, ixy, ixz, iyz = moments
    low, middle, high = np.linalg.eigvalsh([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    if low > LEAST_MOMENT and high <= (low + middle) * (1.0 + ROUNDING):
        return
    mean = max((ixx + iyy + izz) / 3.0, SMALLEST_MOMENT)
    for name, moment in zip(MOMENTS, [mean, mean, mean, 0.0, 0.0, 0.0], strict=True):
        cast(Element, link.find("inertial/inertia")).set(name, repr(float(moment)))
    if told_of:
        (told.no_moment if low <= LEAST_MOMENT else told.no_triangle).append(link.get("name", ""))


def _number(link: Element, inertial: Element, tag: str, attribute: str) -> float:
    """An attribute of the inertial's element `tag`; 0 where it is missing."""
    part = inertial.find(tag)
    text = "0" if part is None else part.get(attribute, "0")
    number = number_of(text)
    if math.isnan(number):
        given = f"Link '{link.get('name')}' has '{text}' in <{tag} {attribute}=...>"
        raise UsageError(f"{given}. Give a finite number of at most {LARGEST:g}.")
    return number


def _settle_meshes(link: Element, moves: bool, find: Callable[[str], Path], told: _Told) -> int:
    """Write where the link's meshes are, and take out those that cannot be read and need not; how many bytes they have.

    Raises:
        UsageError: There is no file for one that moves and collides.
    """
    name, total = link.get("name", ""), 0
    for part in list(link):
        for mesh in part.findall("geometry/mesh"):
            file = None
            try:
                file = _locate(mesh, find, f"Link '{name}'")
                total += file.stat().st_size
                if part.tag == "visual":
                    _require_surface(part, mesh, f"Link '{name}'")
                elif not moves:  # one that moves is read later, and required
                    read_points(mesh, f"Link '{name}'")
            except UsageError as error:
                if part.tag == "collision" and moves:
                    raise
                link.remove(part)
                if part.tag == "collision":
                    told.untouched.setdefault(name, str(error))
                elif file is not None and needs_extra(file):
                    told.unread.append(file.suffix.lower())
                else:
                    told.undrawn.append(str(error))
                break
    return total


def _locate(mesh: Element, find: Callable[[str], Path], owner: str) -> Path:
    """Write where a mesh is, and return that."""
    try:
        file = find(mesh.get("filename", ""))
    except UsageError as error:
        raise UsageError(f"{owner} {error}") from error
    mesh.set("filename", str(file))
    return file


def _require_surface(visual: Element, mesh: Element, owner: str) -> None:
    """Raises unless a drawing can be drawn, where its origin says."""
    scale, _ = read_scale(mesh, owner), read_origin(visual, owner)
    file = Path(mesh.get("filename", ""))
    try:
        surface = read_mesh(file)
    except UsageError as error:
        raise UsageError(f"{owner} has the mesh {error}") from error
    first, second, third = np.moveaxis((surface.vertices * scale)[surface.faces], 1, 0)
    area = np.linalg.norm(np.cross(second - first, third - first), axis=1).sum() / 2.0
    if len(surface.vertices) < FEWEST_POINTS or area < SMALLEST_AREA:
        raise UsageError(f"{owner} has the mesh '{file}', which has no surface. Export it again.")
