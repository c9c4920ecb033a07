"""The XML of a URDF, read as ROS's parser reads it: without a word of namespaces, and bounded."""

import re
from typing import NamedTuple
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


class _BoundedBuilder(ElementTree.TreeBuilder):
    """Builds a tree that is not large, of a text that defines no words of its own."""

    def __init__(self) -> None:
        super().__init__()
        self._count = self._depth = 0
        self.has_prefixes = self.has_namespace = False

    def start(self, tag: str, attrs: dict[str, str], /) -> Element:
        """Called by the parser for every element that begins."""
        self._count, self._depth = self._count + 1, self._depth + 1
        if self._count > MOST_ELEMENTS or self._depth > MOST_LEVELS:
            raise UsageError(
                f"The URDF has more than {MOST_ELEMENTS:,} elements, or {MOST_LEVELS} within one another. Simplify it."
            )
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
        raise UsageError(f"The URDF has a <!DOCTYPE {name}>, which no URDF needs. Take it out.")


def read_xml(text: str) -> UrdfXml:
    """The XML of a URDF.

    Blank lines and comments may stand before the XML declaration.

    Args:
        text: XML with the outermost element `<robot>`.

    Raises:
        UsageError: The text is no such XML, or too large.
    """
    begun, builder = _without_late_declaration(text), _BoundedBuilder()
    parser = expat.ParserCreate()  # no separator of namespaces: a prefix is a part of the name
    parser.buffer_text = True
    parser.StartElementHandler, parser.EndElementHandler = builder.start, builder.end
    parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = builder.data, builder.doctype
    try:
        parser.Parse(begun, True)
        robot: Element = builder.close()
    except (expat.ExpatError, ValueError) as error:  # the latter of half characters
        raise UsageError(f"The URDF is not well-formed XML: {error}. Correct it there.") from error
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
