"""The tree of links that a URDF describes, and the serial chain of joints from its root link to a named tip link.

Only what kinematics needs is read: joints, their frames, axes and limits. Reference: http://wiki.ros.org/urdf/XML/joint
"""

import json
import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, NamedTuple, cast, get_args
from xml.etree import ElementTree
from xml.etree.ElementTree import Element
from xml.parsers import expat

from harness.errors import UsageError

MOST_ELEMENTS = 20_000
"""The most elements of a URDF's XML: a hundred for each of its links."""
MOST_LEVELS = 30
"""Elements within one another; a URDF has six."""
BLANKS = re.compile(r"\s*")


class UrdfXml(NamedTuple):
    """A URDF's XML.

    Attributes:
        text: It, for every parser, whether it knows namespaces or not; the text that was given where that is such a
            text.
        robot: The outermost element. Names with a prefix and declarations of namespaces are left out.
    """

    text: str
    robot: Element


class BoundedBuilder(ElementTree.TreeBuilder):
    """Builds a tree that is not large, of a text that defines no words of its own.

    Args:
        noun: What the text is, for messages.
        elements: The most that it may have.
        levels: How deep they may lie in one another.
    """

    def __init__(self, noun: str, elements: int, levels: int) -> None:
        super().__init__()
        self._noun, self._most, self._levels = noun, elements, levels
        self._count = self._depth = 0
        self.has_prefixes = self.has_namespace = False

    def read(self, text: str | bytes) -> Element:
        """The outermost element.

        Raises:
            UsageError: It is no XML, or too large.
        """
        parser = expat.ParserCreate()  # no separator of namespaces: a prefix is a part of the name
        parser.buffer_text = True
        parser.StartElementHandler, parser.EndElementHandler = self.start, self.end
        parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = self.data, self.doctype
        try:
            parser.Parse(text, True)
            return self.close()
        except (expat.ExpatError, ValueError) as error:  # the latter of half characters
            raise UsageError(f"The {self._noun} is not well-formed XML: {error}. Correct it there.") from error

    def start(self, tag: str, attrs: dict[str, str], /) -> Element:
        """Called by the parser for every element that begins."""
        self._count, self._depth = self._count + 1, self._depth + 1
        if self._count > self._most or self._depth > self._levels:
            told = f"more than {self._most:,} elements, or {self._levels} within one another"
            raise UsageError(f"The {self._noun} has {told}. Simplify it.")
        self.has_prefixes |= any(":" in name for name in (tag, *attrs))
        self.has_namespace |= "xmlns" in attrs
        own = {name: value for name, value in attrs.items() if ":" not in name and name != "xmlns"}
        return super().start(tag, own)

    def end(self, tag: str, /) -> Element:
        """Called by the parser for every element that ends."""
        self._depth -= 1
        return super().end(tag)

    def doctype(self, name: str, *rest: object) -> None:
        """Called by the parser before a document type is read, which could define words as long as it likes."""
        raise UsageError(f"The {self._noun} has a <!DOCTYPE {name}>, which none needs. Take it out.")


def read_xml(text: str) -> UrdfXml:
    """The XML of a URDF.

    Blank lines and comments may stand before the XML declaration.

    Args:
        text: XML with the outermost element `<robot>`.

    Raises:
        UsageError: The text is no such XML, or too large.
    """
    begun = _without_late_declaration(text)
    builder = BoundedBuilder("URDF", MOST_ELEMENTS, MOST_LEVELS)
    robot = builder.read(begun)
    if robot.tag != "robot":
        raise UsageError(f"The outermost element is <{robot.tag}>, a URDF's is <robot>. Give a URDF.")
    _drop_prefixed(robot)
    if begun is text and not builder.has_namespace and (not builder.has_prefixes or _knows_its_prefixes(text)):
        return UrdfXml(text, robot)
    return UrdfXml(ElementTree.tostring(robot, encoding="unicode"), robot)


def _without_late_declaration(text: str) -> str:
    """A text whose XML declaration stands behind blanks or comments, without it; lines keep their numbers."""
    place = _after_comments(text)
    end = text.find("?>", place)
    if place == 0 or not text.startswith("<?xml", place) or end < 0 or text[:place] == "\ufeff":
        return text
    return text[:place] + " " * len("<?") + "\n" * text.count("\n", place, end) + text[end + len("?>") :]


def _after_comments(text: str) -> int:
    """Where the blanks and comments that a text begins with end."""
    place = int(text.startswith("\ufeff"))
    while blanks := BLANKS.match(text, place):
        place = blanks.end()
        end = text.find("-->", place + len("<!--")) if text.startswith("<!--", place) else -1
        if end < 0:
            break
        place = end + len("-->")
    return place


def _drop_prefixed(element: Element) -> None:
    for part in list(element):
        if ":" in part.tag:
            element.remove(part)
        else:
            _drop_prefixed(part)


def _knows_its_prefixes(text: str) -> bool:
    """Whether a parser that knows namespaces reads the text: every prefix is declared."""
    try:
        ElementTree.XML(text)
    except ElementTree.ParseError:
        return False
    return True


JointKind = Literal["fixed", "revolute", "continuous", "prismatic"]
KINDS = (*get_args(JointKind), "planar", "floating")
"""All that a URDF has; the last two move in several ways at once and cannot be on a chain."""
Vector = tuple[float, float, float]

WORLD, MOUNT = "world", "mount"
"""The link that engines take for the world, if there is one of that name; what such a link is called elsewhere."""
MOST_LINKS = 200
"""The most links of a URDF: an arm has ten, a humanoid with both hands less than 150."""
SHOWN = 20
"""Names in a message."""
LARGEST = 1e18
"""The largest number: more than any arm's, and products of several stay finite."""
LONGEST_SLIDE = 100.0
"""The longest way of a slide, [m]: more than any gantry's."""
NUMBER = re.compile(r"\s*[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?\s*", re.ASCII)
"""A number as ROS reads one; `float` also takes 1_000."""


@dataclass(frozen=True)
class Joint:
    """One joint: a constant step from its parent link's frame to its own, then its motion to its child link's frame.

    Attributes:
        name: Unique in the URDF.
        kind: How it moves; a fixed joint does not.
        parent: Name of the link it hangs on.
        child: Name of the link it carries.
        xyz: Origin of the joint's frame in the parent link's frame [m].
        rpy: Orientation of the joint's frame: turns about the parent's fixed x, then y, then z axis [rad].
        axis: Unit vector in the joint's frame along which it slides or about which it turns; unused when fixed.
        lower: Smallest position, [rad] or, for a prismatic joint, [m]; -inf for a continuous or fixed joint.
        upper: Largest position, as `lower`; inf for a continuous or fixed joint.
        velocity: Largest speed, [rad/s] or [m/s], positive; None where the URDF names none that is.
        effort: Largest torque or force, [N m] or [N], likewise.
    """

    name: str
    kind: JointKind
    parent: str
    child: str
    xyz: Vector
    rpy: Vector
    axis: Vector
    lower: float
    upper: float
    velocity: float | None
    effort: float | None = None


@dataclass(frozen=True, eq=False)
class Urdf:
    """A URDF that was parsed and checked.

    Names are unique, each joint has a known type and joins two links, and the links are one tree.

    Attributes:
        text: The URDF as text, for engines; see `harness.robot.urdf`.
        element: The same as `<robot>`; who wants to change it changes a copy.
    """

    text: str = field(repr=False)
    element: Element

    @cached_property
    def links(self) -> Mapping[str, Element]:
        """By their names, in the order of the text."""
        return {link.get("name", ""): link for link in self.element.findall("link")}

    @cached_property
    def joints(self) -> tuple[Element, ...]:
        """In the order of the text."""
        return tuple(self.element.findall("joint"))

    @cached_property
    def carriers(self) -> Mapping[str, Element]:
        """The joint that carries each link, by the link's name; all links but the root have one."""
        return {linked(joint, "child"): joint for joint in self.joints}


def read_chain(urdf: Urdf, tip: str) -> tuple[Joint, ...]:
    """The joints from the root link to `tip`, in that order, fixed ones included.

    Args:
        urdf: The URDF.
        tip: Name of the link where the chain ends.

    Returns:
        The joints, at least one of which moves.

    Raises:
        UsageError: There is no such link, or a joint of the chain cannot be computed with.
    """
    require_link(urdf, tip)
    chain = tuple(_read_joint(joint) for joint in path_to(tip, urdf.carriers))
    if all(joint.kind == "fixed" for joint in chain):
        raise UsageError(f"No joint moves between the root link and '{tip}'. Name a tip beyond a joint that moves.")
    return chain


def require_link(urdf: Urdf, tip: str) -> None:
    """Raise unless a URDF has a link.

    Raises:
        UsageError: It has none of that name; the message names those that it has.
    """
    if tip not in urdf.links:
        raise UsageError(f"No link '{tip}' in the URDF. Name one of its links as the tip: {quoted(urdf.links)}.")


def parse_urdf(text: str) -> Urdf:
    """The URDF that a text is.

    Args:
        text: XML with the outermost element `<robot>`.

    Raises:
        UsageError: The text is no URDF, or not one that `Urdf` describes.
    """
    urdf = Urdf(*read_xml(text))
    links = [_name(link) for link in urdf.element.findall("link")]
    if not links:
        raise UsageError("The URDF has no <link>. If it is a xacro file, expand it: xacro arm.urdf.xacro > arm.urdf")
    if len(links) > MOST_LINKS:
        raise UsageError(f"The URDF has {len(links):,} links, {MOST_LINKS} are allowed. Give the arm alone.")
    _check_unique("link", links)
    _check_unique("joint", [_name(joint) for joint in urdf.joints])
    for joint in urdf.joints:
        if joint.get("type") not in KINDS:
            raise _joint_error(joint, f"is of type '{joint.get('type')}'; allowed: {', '.join(KINDS)}. Change it.")
    _check_tree(links, urdf.joints)
    for link in links:
        path_to(link, urdf.carriers)  # raises where joints form a loop
    if WORLD in urdf.carriers:
        rename_world(urdf.element)
        return Urdf(ElementTree.tostring(urdf.element, encoding="unicode"), urdf.element)
    return urdf


def rename_world(robot: Element) -> str:
    """Give the link `world` another name, in place, and return it: engines take `world` for the world itself."""
    name = free_name(MOUNT, (link.get("name", "") for link in robot.iterfind("link")))
    for link in robot.iterfind(f"link[@name='{WORLD}']"):
        link.set("name", name)
    for end in robot.iterfind(f"joint/*[@link='{WORLD}']"):
        end.set("link", name)
    return name


def free_name(name: str, taken: Iterable[str]) -> str:
    """A name that nothing has, as near to the wanted one as can be."""
    known = set(taken)
    while name in known:
        name += "_"
    return name


def _check_unique(what: str, names: Sequence[str]) -> None:
    repeated = _repeated(names)
    if repeated:
        raise UsageError(f"The URDF has more than one {what} {quoted(repeated)}. Give each its own name.")


def _repeated(names: Sequence[str]) -> list[str]:
    return sorted(name for name, count in Counter(names).items() if count > 1)


def _check_tree(links: Sequence[str], joints: Sequence[Element]) -> None:
    """Raises unless each joint joins two links of the URDF, no link has two parents, and exactly one has none."""
    children = [linked(joint, "child") for joint in joints]
    parents = [linked(joint, "parent") for joint in joints]
    unknown = sorted({*children, *parents} - set(links))
    if unknown:
        raise UsageError(f"Joints name links that the URDF does not define: {quoted(unknown)}. Define or rename them.")
    shared = _repeated(children)
    if shared:
        raise UsageError(f"More than one joint carries link {quoted(shared)}. Keep one joint for each link.")
    carried = set(children)
    roots = [link for link in links if link not in carried]
    if len(roots) != 1:
        found = quoted(roots) or "none"
        raise UsageError(f"A URDF has one root link, carried by no joint; found: {found}. Join all links in one tree.")


def path_to(tip: str, carrier: Mapping[str, Element]) -> list[Element]:
    """The joints from the root to `tip`; found upwards from the tip, where the way is unique.

    Args:
        tip: A link.
        carrier: The joint that carries each link, see `Urdf.carriers`.

    Raises:
        UsageError: The joints form a loop.
    """
    path: list[Element] = []
    link = tip
    while link in carrier:
        if len(path) == len(carrier):  # each of them once, and still no root
            raise UsageError(f"The joints above link '{tip}' form a loop. Remove one: a URDF is a tree.")
        path.append(carrier[link])
        link = linked(carrier[link], "parent")
    return path[::-1]


def linked(joint: Element, end: Literal["parent", "child"]) -> str:
    """Name of the link at one end of a joint.

    Raises:
        UsageError: The joint names none.
    """
    link = _text(joint, end, "link")
    if link is None:
        raise _joint_error(joint, f"names no {end} link. Give it <{end} link=.../>.")
    return link


def _read_joint(joint: Element) -> Joint:
    kind, allowed = cast(JointKind, joint.get("type")), get_args(JointKind)
    if kind not in allowed:
        told = f"is of type '{kind}'; allowed on the chain: {', '.join(allowed)}"
        raise _joint_error(joint, f"{told}. Change it, {_or_hold(joint)}")
    if kind != "fixed" and joint.find("mimic") is not None:
        told = "mimics another one, but each joint of the chain moves by itself"
        raise _joint_error(joint, f"{told}. Remove <mimic>, {_or_hold(joint)}")
    lower, upper = _limits(joint, kind)
    return Joint(
        name=_name(joint),
        kind=kind,
        parent=linked(joint, "parent"),
        child=linked(joint, "child"),
        xyz=read_vector(joint, "origin", "xyz", default=(0.0, 0.0, 0.0)),
        rpy=read_vector(joint, "origin", "rpy", default=(0.0, 0.0, 0.0)),
        axis=(1.0, 0.0, 0.0) if kind == "fixed" else read_axis(joint),
        lower=lower,
        upper=upper,
        velocity=None if kind == "fixed" else _positive_limit(joint, "velocity"),
        effort=None if kind == "fixed" else _positive_limit(joint, "effort"),
    )


def read_axis(joint: Element) -> Vector:
    """Unit vector along which the joint slides or about which it turns, in the joint's frame.

    Raises:
        UsageError: It has no length, or an <axis> without xyz, which parsers read in different ways.
    """
    if joint.find("axis") is not None and _text(joint, "axis", "xyz") is None:
        raise _joint_error(joint, "has an <axis> without xyz. Give it <axis xyz=.../>.")
    x, y, z = read_vector(joint, "axis", "xyz", default=(1.0, 0.0, 0.0))  # the default of the URDF reference
    length = math.hypot(x, y, z)
    if length == 0.0:
        raise _joint_error(joint, "has an axis of zero length. Give one that has a direction.")
    return x / length, y / length, z / length


def _limits(joint: Element, kind: JointKind) -> tuple[float, float]:
    if kind in ("fixed", "continuous"):
        return -math.inf, math.inf
    lower, upper = read_number(joint, "limit", "lower"), read_number(joint, "limit", "upper")
    if lower is None or upper is None:
        raise _joint_error(
            joint, f"is {kind} and has no limits. Give it <limit lower=... upper=.../>, {_or_write(joint, kind)}"
        )
    if lower >= upper:
        raise _joint_error(
            joint,
            f"has the limits {lower:g} to {upper:g}. Give a lower one below the upper one, {_or_write(joint, kind)}",
        )
    if kind == "prismatic" and upper - lower > LONGEST_SLIDE:  # a placeholder, from which home and noise would come
        raise _joint_error(
            joint,
            f"slides from {lower:g} to {upper:g} m, {LONGEST_SLIDE:g} m are allowed. Give the slide's own limits, "
            f"{_or_write(joint, kind)}",
        )
    return lower, upper


def _or_hold(joint: Element) -> str:
    """What to write into a robot.toml instead, of a joint that cannot move."""
    return f"or hold the joint in a robot.toml: fixed = {{ {json.dumps(_name(joint), ensure_ascii=False)} = 0 }}"


def _or_write(joint: Element, kind: JointKind) -> str:
    """What to write into a robot.toml instead."""
    key, example = ("range_m", "[0, 0.2]") if kind == "prismatic" else ("range_deg", "[-90, 90]")
    name = json.dumps(_name(joint), ensure_ascii=False)
    return f"or the arm's own in a robot.toml: {key} = {{ {name} = {example} }}"


def _positive_limit(joint: Element, name: str) -> float | None:
    """A largest speed or effort; None where none stands there: exporters write 0, nothing or the largest float."""
    limit = number_of(_text(joint, "limit", name) or "")
    return limit if limit > 0.0 else None


def read_vector(joint: Element, tag: str, attribute: str, default: Vector) -> Vector:
    """Three numbers in an attribute of the joint's element `tag`.

    Raises:
        UsageError: They are not three finite numbers.
    """
    text = _text(joint, tag, attribute)
    if text is None:
        return default
    words = text.split()
    if len(words) != 3:
        raise _joint_error(joint, f"has {len(words)} numbers in <{tag} {attribute}=...>. Give three.")
    numbers = [_finite(joint, word) for word in words]
    return numbers[0], numbers[1], numbers[2]


def read_number(joint: Element, tag: str, attribute: str) -> float | None:
    """An attribute of the joint's element `tag`; None where it is missing.

    Raises:
        UsageError: It is no finite number.
    """
    text = _text(joint, tag, attribute)
    return None if text is None else _finite(joint, text)


def number_of(text: str) -> float:
    """The number that a text is; NaN where it is none, or one beyond `LARGEST`."""
    number = float(text) if NUMBER.fullmatch(text) else math.nan
    return number if abs(number) <= LARGEST else math.nan


def _finite(joint: Element, text: str) -> float:
    number = number_of(text)
    if math.isnan(number):
        raise _joint_error(joint, f"has '{text}' where a finite number belongs, of at most {LARGEST:g}. Correct it.")
    return number


def _text(joint: Element, tag: str, attribute: str) -> str | None:
    """The attribute of the joint's element `tag`; None where either is missing."""
    element = joint.find(tag)
    return None if element is None else element.get(attribute)


def _name(element: Element) -> str:
    name = element.get("name")
    if name is None:
        raise UsageError(f"A <{element.tag}> of the URDF has no name. Give it one.")
    return name


def _joint_error(joint: Element, message: str) -> UsageError:
    return UsageError(f"Joint '{joint.get('name')}' {message}")


def quoted(names: Iterable[str]) -> str:
    """The first of the names, as many as fit into a message."""
    shown = [f"'{name}'" for name in names]
    return ", ".join(shown[:SHOWN]) + (", ..." if len(shown) > SHOWN else "")
