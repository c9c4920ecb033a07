"""A look at an MJCF before MuJoCo compiles it: what comes of it is bounded, and whatever it names is a regular file.

MuJoCo waits for a pipe, and makes as many copies, points and pixels as a file asks for.
https://mujoco.readthedocs.io/en/stable/XMLreference.html
"""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree.ElementTree import Element

from harness.errors import UsageError, one_line
from harness.files import open_regular, read_bytes
from harness.robot import BoundedBuilder

MOST_BYTES, MOST_FILE_BYTES = 16 * 2**20, 64 * 2**20
"""The most bytes of an XML file, and of a mesh, a picture or a height field."""
MOST_FILES, MOST_NESTED = 1_000, 20
"""The most XML files of a model, and how deep they may name one another."""
MOST_ELEMENTS, MOST_LEVELS = 100_000, 400
"""The most elements, with the copies that are made of them, and how deep they may lie in one another."""
MOST_PIXELS = 2**27
"""The most pixels of all pictures and heights of all height fields."""
GRIDS = ("composite", "flexcomp")
"""Elements that make as many as the product of their ``count``."""
MOST: Mapping[str, tuple[float, tuple[str, ...]]] = {
    "size": (1e6, ("nuserdata", "nkey", "nuser_body", "nuser_jnt", "nuser_geom", "nuser_site", "nuser_cam",
                   "nuser_tendon", "nuser_actuator", "nuser_sensor", "njmax", "nconmax", "nstack")),
    "mesh": (100, ("params", "octree_maxdepth")),
    "skin": (100, ("subgrid",)),
    "numeric": (1e6, ("size",)),
    "lengthrange": (1e3, ("inttotal",)),
    "camera": (1e4, ("resolution",)),
    "contact": (1e4, ("num",)),
    "user": (1e4, ("dim",)),
}  # fmt: skip
"""The largest numbers that say how much room or time something takes, by the element."""
FOLDERS = ("meshdir", "texturedir", "assetdir")
FILE = re.compile("file(right|left|up|down|front|back)?")
PNG = b"\x89PNG\r\n\x1a\n"
NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)(e[+-]?\d{1,3})?", re.ASCII | re.IGNORECASE)


def require_bounded(path: Path) -> None:
    """See what would come of a file, and of those that it names.

    Args:
        path: It.

    Raises:
        UsageError: That is more than is allowed, or no regular file.
    """
    look = _Look()
    look.weigh(path, 0)
    _require(look.pixels, MOST_PIXELS, "its pictures and height fields have", "pixels")


@dataclass
class _Look:
    """What was found in the files that were looked at.

    Attributes:
        weights: How many elements each model brings.
        pixels: Those of all pictures, and the heights of all height fields.
    """

    weights: dict[Path, float] = field(default_factory=dict)
    pixels: float = 0.0

    def weigh(self, path: Path, depth: int) -> float:
        """The elements of a model, with all copies, once it was looked at."""
        if path in self.weights:
            return self.weights[path]
        _require(depth, MOST_NESTED, "its files name one another", "levels deep")
        self.weights[path], total = math.inf, 0.0  # until it is known: none holds itself
        found = list(_elements(path))
        names = {it.get("name") or Path(it.get("file", "")).stem: it for it, _ in found if it.tag == "model"}
        folders = {"", *(it.get(name, "") for it, _ in found if it.tag == "compiler" for name in FOLDERS)}
        for element, times in found:
            grid = max(1.0, math.prod(_numbers(element, "count"))) if element.tag in GRIDS else 1.0
            model = names.get(element.get("model", "")) if element.tag == "attach" else None
            inner = 0.0 if model is None else self.weigh(path.parent / model.get("file", ""), depth + 1)
            total += times * (grid + inner)
            _require(total, MOST_ELEMENTS, "it makes", "elements, copies counted")
            most, attributes = MOST.get(element.tag, (0.0, ()))
            for name in attributes:
                _require(max(_numbers(element, name)), most, f"{name} of <{element.tag}> is", "")
            if element.tag in {"texture", "hfield"}:
                sides = ("width", "height") if element.tag == "texture" else ("nrow", "ncol")
                self.pixels += math.prod(max(_numbers(element, side)) for side in sides)
            if element.tag != "include":
                self._look_at_files(element, path.parent, folders)
        self.weights[path] = total
        return total

    def _look_at_files(self, element: Element, base: Path, folders: set[str]) -> None:
        """See that the files of an element are regular; MuJoCo tells which is not there."""
        for name in (name for key, name in element.attrib.items() if FILE.fullmatch(key)):
            for place in {base / folder / part for folder in folders for part in (name, Path(name).name)}:
                if element.tag != "model" and place.exists():
                    try:
                        with open_regular(place, MOST_FILE_BYTES) as file:
                            head = file.read(24)
                    except OSError as error:
                        raise UsageError(f"it names '{place}' ({error.strerror}). Name a regular file") from error
                    if head.startswith(PNG) and element.tag in {"texture", "hfield"}:
                        self.pixels += int.from_bytes(head[16:20]) * int.from_bytes(head[20:24])


def _require(count: float, most: float, what: str, noun: str) -> None:
    if not count <= most:
        told = f"{what} {count:,.0f} {noun}".rstrip()
        raise UsageError(f"{told}, {most:,.0f} are allowed. Make it smaller")


def _elements(path: Path) -> Iterator[tuple[Element, int]]:
    """The elements of a file and of those that it includes, and how many each becomes by ``<replicate>``."""
    waiting, seen = [(_root(path), 1)], 0
    while waiting:
        element, times = waiting.pop()
        yield element, times
        if element.tag == "replicate":
            times *= int(max(1.0, *_numbers(element, "count")))
        waiting += [(child, times) for child in element]
        if element.tag == "include":
            seen += 1
            _require(seen, MOST_FILES, "it includes", "files")
            waiting += [(child, times) for child in _root(path.parent / element.get("file", ""))]


def _root(path: Path) -> Element:
    try:
        text = read_bytes(path, MOST_BYTES).decode()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or one_line(error)
        raise UsageError(f"'{path}' cannot be read ({reason}). Name a regular file in UTF-8") from error
    return BoundedBuilder("MJCF", MOST_ELEMENTS, MOST_LEVELS).read(text)


def _numbers(element: Element, name: str) -> list[float]:
    """The numbers of an attribute; 0 where there is none."""
    return [float(it[0]) for it in NUMBER.finditer(element.get(name, ""))] or [0.0]
