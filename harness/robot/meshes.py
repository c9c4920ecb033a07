"""Mesh files: where a URDF's name for one leads, and the surface in it.

STL and OBJ are read here; COLLADA, glTF and PLY by `trimesh`, of the extra `meshes`.
"""

import json
import math
import os
import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from importlib.util import find_spec
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Ints
from harness.errors import UsageError
from harness.files.bounded import kind_at, read_bytes
from harness.robot.packages import package_folders
from harness.robot.urdf import BoundedBuilder
from harness.text import one_line

HEADER = 84
"""Bytes of a binary STL before its first triangle; the last four say how many there are."""
MOST_BYTES = 64 * 2**20
"""The most bytes of a file: a binary STL of `MOST_TRIANGLES` has 10 MiB, one in text some five times as much."""
MOST_TRIANGLES = 200_000
"""The most triangles of a surface: MuJoCo takes no more of an STL either."""
LONGEST_LINE = 1_000
"""Bytes that are read of the line of a point."""
LARGEST = 1e9
"""The largest coordinate of a point, in whatever unit: in micrometres a kilometre."""
NO_POINTS = f"it holds no points, or some that are not finite or beyond {LARGEST:g}"
SCENES: Mapping[str, tuple[str, ...]] = {
    ".dae": ("trimesh", "collada"),
    ".glb": ("trimesh",),
    ".gltf": ("trimesh",),
    ".ply": ("trimesh",),
}
"""The formats that others read, by the suffix in small letters, and the packages that this takes."""
MOST_NUMBERS = 60 * MOST_TRIANGLES
"""The most numbers of a scene, some twenty for each corner; a third as many entries of a glTF's arrays."""
MOST_PLACED, MOST_ELEMENTS, MOST_LEVELS = 20_000, 100_000, 400
"""The most nodes of a scene, with all copies; elements of its text, and how deep they may lie in one another."""
MOST_HEAD = 10_000
"""The most bytes of the head of a PLY."""
TO_READ_THEM = "pip install 'fd100-harness[meshes]'"
UNIT = re.compile(rb"<unit[^>]*?\bmeter\s*=\s*[\"']([^\"']+)")
"""How many metres the unit of a COLLADA file has."""
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def locate_mesh(name: str, folder: Path, packages: Mapping[str, Path] = MappingProxyType({})) -> Path:
    """The file that a URDF in `folder` means by `name`.

    A relative name starts at `folder`, else at the package ''. ``package://PACKAGE/REST`` is looked for where
    the folders of the package may be, see `package_folders`; then as REST in `folder` and in each folder around it: the
    package is the folder that the URDF lies in or beside, whatever a checkout is called.

    Args:
        name: A path, or ``package://``, ``model://`` or ``file://`` and a path.
        folder: Of the URDF.
        packages: Folders of packages by their names; that of the name '' holds all others, or is one.

    Returns:
        An absolute path.

    Raises:
        UsageError: There is no such file, or it is too large; says where it was looked for.
    """
    scheme, separator, rest = name.rpartition("://")
    if separator and scheme not in {"package", "model", "file"}:
        raise UsageError(f"has the mesh '{name}': allowed are paths, package://, model:// and file://. Change it.")
    folder = folder.absolute()
    is_packaged = scheme in {"package", "model"}
    look = _places_in_packages if is_packaged else _places
    for place in look(rest, folder, packages):
        if os.path.isfile(place):  # no error, whatever the name
            if (size := place.stat().st_size) > MOST_BYTES:  # also of what an engine alone reads
                told = f"has the mesh '{place}' of {size:,} bytes, {MOST_BYTES:,} are allowed"
                raise UsageError(f"{told}. Simplify it.")
            return place
    raise UsageError(
        f"has the mesh '{name}', and there is no file '{next(look(rest, folder, packages))}'"
        f"{', nor one in the folders around it' * is_packaged}. "
        f"Put it there, {_or_write(rest, is_packaged)} or take its <visual> or <collision> out of the URDF."
    )


def _or_write(rest: str, is_packaged: bool) -> str:
    """What to write into a robot.toml."""
    if not is_packaged:
        return 'say in a robot.toml where such names start, meshes = "FOLDER",'
    package = json.dumps(rest.partition("/")[0], ensure_ascii=False)
    return f'say in a robot.toml where the package lies, meshes = {{ {package} = "FOLDER" }},'


def _places(rest: str, folder: Path, packages: Mapping[str, Path]) -> Iterator[Path]:
    """Where a file with a relative name may lie; arguments as for `locate_mesh`."""
    yield folder / rest
    if "" in packages:
        yield packages[""] / rest


def _places_in_packages(rest: str, folder: Path, packages: Mapping[str, Path]) -> Iterator[Path]:
    """Where a file of a package, PACKAGE/REST, may lie; arguments as for `locate_mesh`."""
    package, _, inner = rest.partition("/")
    places = (*package_folders(package, folder, packages), *_places("", folder, packages), *folder.parents)
    yield from (place / inner for place in places)


@dataclass(frozen=True, eq=False)
class Mesh:
    """A surface of triangles; its arrays are read-only.

    Attributes:
        vertices: Its points, in the file's unit and frame, shape (count, 3).
        faces: Numbers of each triangle's corners, shape (triangles, 3); none where the file has only points.
    """

    vertices: Float
    faces: NDArray[np.int32]


def read_mesh(path: Path) -> Mesh:
    """The surface in a file.

    Args:
        path: An STL file, binary or text; a Wavefront OBJ, or a file of `SCENES`, whose objects are taken as one.

    Raises:
        UsageError: The file cannot be read, is of another format or too large, or holds no points that are finite.
    """
    if path.suffix.lower() not in READERS:
        raise UsageError(f"'{path}' is none of {', '.join(READERS)}. Convert it to STL.")
    if needs_extra(path):
        raise UsageError(f"'{path}' is no STL or OBJ file. To have it read: {TO_READ_THEM}. Or convert it to STL.")
    try:
        return _read(path, path.stat().st_mtime_ns)
    except Exception as error:  # bytes of anybody: too large for a number's type, for the memory, ...
        if (kind := kind_at(path)) is not None:
            raise UsageError(f"'{path}' is no mesh, it is {kind.sentence}") from error
        problem = error.strerror if isinstance(error, OSError) and error.strerror else one_line(str(error))
        raise UsageError(f"'{path}' cannot be read as a mesh ({problem.rstrip('.')}). Export it again.") from error


@lru_cache(maxsize=128)
def _read(path: Path, modified: int) -> Mesh:
    """The surface in a file that was `modified` then: an arm is read several times, and its meshes take longest."""
    mesh = READERS[path.suffix.lower()](read_bytes(path, MOST_BYTES))
    if not mesh.vertices.size or not (np.abs(mesh.vertices) <= LARGEST).all():  # NaN is not either
        raise ValueError(NO_POINTS)
    mesh.vertices.flags.writeable = mesh.faces.flags.writeable = False
    return mesh


def needs_extra(path: Path) -> bool:
    """Whether a file is of a format whose reader is not installed."""
    return not all(map(find_spec, SCENES.get(path.suffix.lower(), ())))


def _read_stl(data: bytes) -> Mesh:
    count = int.from_bytes(data[HEADER - 4 : HEADER], "little")
    # In a text these bytes are letters, which make a number that no file is long enough for.
    if len(data) >= HEADER + count * TRIANGLE.itemsize:
        _require_few(count)
        corners = np.frombuffer(data, TRIANGLE, count=count, offset=HEADER)["corners"].reshape(-1, 3).astype(np.float64)
        if not np.isfinite(corners).all():
            raise ValueError(NO_POINTS)
    else:
        corners = _points(data, b"vertex")
    if len(corners) % 3:
        raise ValueError("its last triangle is not complete")
    vertices, numbers = distinct(corners)
    faces = numbers.reshape(-1, 3).astype(np.int32)
    first, second, third = faces.T
    return Mesh(vertices, faces[(first != second) & (second != third) & (third != first)])


def distinct(points: Float) -> tuple[Float, NDArray[np.intp]]:
    """The points without those that come again, in order of x, then y, then z; `np.unique` takes four times as long.

    Args:
        points: Shape (count, 3), finite.

    Returns:
        The distinct points, (distinct, 3), and for each of `points` the number of its equal among them, (count,).
    """
    order = np.lexsort(points.T[::-1])
    ordered = points[order]
    is_new = np.ones(len(points), bool)
    is_new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    numbers = np.empty(len(points), np.intp)
    numbers[order] = np.cumsum(is_new) - 1
    return ordered[is_new], numbers


def _read_obj(data: bytes) -> Mesh:
    data = data.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ")  # a line that goes on in the next one
    vertices = _points(data, b"v")
    numbers = np.fromiter(_corners_of_obj(data), np.int64).reshape(-1, 3)
    # They begin with 1; what is below 0 is counted from the end, as most files with it list all points first.
    corners = np.where(numbers < 0, numbers + len(vertices), numbers - 1)
    _require_corners(corners, len(vertices))
    return Mesh(vertices, corners.astype(np.int32))


def _require_corners(numbers: Ints, count: int) -> None:
    """Raises unless all triangles have corners among `count` points."""
    if numbers.size and not 0 <= numbers.min() <= numbers.max() < count:
        raise ValueError("it has triangles with corners that it does not have")


def _corners_of_obj(data: bytes) -> Iterator[int]:
    """Numbers of the corners of all triangles, three by three; a polygon is a fan of triangles."""
    count = 0
    for number, line in enumerate(re.finditer(rb"^f[ \t]+(.+)$", data, re.MULTILINE)):
        _require_few(number)
        corners = (int(corner[0].partition(b"/")[0]) for corner in re.finditer(rb"\S+", line[1]))
        first = next(corners)
        for one, next_one in pairwise(corners):
            _require_few(count := count + 1)
            yield from (first, one, next_one)


def _points(data: bytes, word: bytes) -> Float:
    """The three numbers behind `word` in each line that begins with it; more than three are left."""
    return np.fromiter(_numbers(data, word), np.float64).reshape(-1, 3)


def _numbers(data: bytes, word: bytes) -> Iterator[float]:
    _require_few(data.count(b"\n" + word + b" ") // 3)  # most of such files are found at once
    # Some programs write the words of a text STL in capital letters.
    pattern = rb"^[ \t]*(?i:" + word + rb")[ \t]+([^\n]{1,%d})" % LONGEST_LINE
    lines = re.finditer(pattern, data, re.MULTILINE)
    for count, line in enumerate(lines):
        _require_few(count // 3)
        x, y, z = line[1].split(None, 3)[:3]
        yield from (float(x), float(y), float(z))


def _require_few(count: float, most: int = MOST_TRIANGLES, noun: str = "triangles or more") -> None:
    if not count <= most:
        raise ValueError(f"it has {count:,} {noun}, {most:,} are allowed")


def _read_scene(data: bytes, suffix: str) -> Mesh:
    """All objects of a scene, where its nodes put them, as RViz and other programs around ROS read it.

    The unit of a COLLADA file counts and its <up_axis> does not; glTF is not turned either. Public arms are made for
    that: so read, their drawings lie where the STLs of the same links do.
    """
    import trimesh

    {".dae": _look_at_collada, ".ply": _look_at_ply}.get(suffix, _look_at_gltf)(data)
    try:
        scene = trimesh.load_scene(BytesIO(data), file_type=suffix[1:], process=False, skip_materials=True)
    except AttributeError as error:  # of what it takes for granted
        raise ValueError("it shows no scene, or is damaged") from error
    unit = UNIT.search(data) if suffix == ".dae" else None
    vertices, faces, points, triangles = [np.empty((0, 3))], [np.empty((0, 3), np.int32)], 0, 0
    for node in scene.graph.nodes_geometry:
        pose, name = scene.graph[node]
        part = scene.geometry[name]
        if not isinstance(part, trimesh.Trimesh):
            continue  # lines
        _require_corners(part.faces, len(part.vertices))
        triangles += len(part.faces)
        _require_few(max(triangles, points // 3))
        mirrored = np.linalg.det(pose[:3, :3]) < 0.0
        vertices.append(part.vertices @ pose[:3, :3].T + pose[:3, 3])
        faces.append(part.faces[:, :: -1 if mirrored else 1] + points)
        points += len(part.vertices)
    scale = float(unit[1]) if unit else 1.0
    return Mesh(np.concatenate(vertices) * scale, np.concatenate(faces).astype(np.int32))


def _look_at_collada(data: bytes) -> None:
    """See that what comes of a COLLADA file is bounded: a node may show others, which show others, many times."""
    if data.startswith(b"PK"):
        raise ValueError("it is packed: unpack it")
    _require_few(sum(map(data.count, (b" ", b"\n", b"\t", b"\r"))), MOST_NUMBERS, "numbers")
    root = BoundedBuilder("COLLADA file", MOST_ELEMENTS, MOST_LEVELS).read(data)
    named = defaultdict[str, list[Element]](list)
    for part in root.iter():
        named[f"#{part.get('id')}"].append(part)
        if part.tag.endswith("vcount"):
            _require_few(sum(map(int, (part.text or "").split())), 3 * MOST_TRIANGLES, "corners")
    _require_few(_weight(root, named, {}), 2 * MOST_BYTES, "bytes, copies counted")


def _weight(part: Element, named: Mapping[str, Sequence[Element]], known: dict[Element, float]) -> float:
    """The bytes of an element's texts and of what it shows; each time it shows something counts for some as well."""
    if part not in known:
        known[part] = math.inf  # until it is known: none holds itself
        shown = named.get(part.get("url", ""), ())
        each = 2 * MOST_BYTES // MOST_PLACED * len(shown)
        known[part] = len(part.text or "") + each + sum(_weight(it, named, known) for it in (*part, *shown))
    return known[part]


def _look_at_gltf(data: bytes) -> None:
    """See that what comes of a glTF file is bounded: its meshes may share arrays, and its arrays bytes."""
    text = data[20 : 20 + int.from_bytes(data[12:16], "little")] if data.startswith(b"glTF") else data
    _require_few(text.count(b","), MOST_ELEMENTS, "parts")
    tree = json.loads(text)
    if any(not it.get("uri", "data:").startswith("data:") for it in tree.get("buffers", ())):
        raise ValueError("its numbers lie in other files: save it as .glb")
    counts = [abs(it["count"]) for it in tree.get("accessors", ())]
    parts = [part for mesh in tree.get("meshes", ()) for part in mesh["primitives"]]
    used = [counts[at] for part in parts for at in (*part["attributes"].values(), part.get("indices", 0))]
    _require_few(max(sum(counts), sum(used)), MOST_NUMBERS // 3, "entries of its arrays")
    _require_few(sum(abs(it["byteLength"]) for it in tree.get("bufferViews", ())), 2 * MOST_BYTES, "bytes")
    _require_few(len(tree.get("nodes", ())), MOST_PLACED, "nodes")


def _look_at_ply(data: bytes) -> None:
    """See that what comes of a PLY is bounded."""
    _require_few(len(data.partition(b"end_header")[0]), MOST_HEAD, "bytes in its head")
    _require_few(data.count(b"\n"), 4 * MOST_TRIANGLES, "lines")
    _require_few(len(data), MOST_BYTES // 2, "bytes")


READERS: Mapping[str, Callable[[bytes], Mesh]] = {
    ".stl": _read_stl,
    ".obj": _read_obj,
    **{suffix: partial(_read_scene, suffix=suffix) for suffix in SCENES},
}
"""By the suffix of the file's name, in small letters."""
