"""Mesh files: where a URDF's name for one leads, and the surface in an STL or OBJ."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import UsageError

HEADER = 84
"""Bytes of a binary STL before its first triangle; the last four say how many there are."""
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def locate_mesh(name: str, folder: Path) -> Path:
    """The file that a URDF in `folder` means by `name`.

    A relative name starts at `folder`. ``package://PACKAGE/REST`` is looked for as PACKAGE/REST, then as REST, in
    `folder` and in each folder around it: the package is the folder that the URDF lies in or beside, whatever a
    checkout is called.

    Args:
        name: A path, or ``package://``, ``model://`` or ``file://`` and a path.
        folder: Of the URDF.

    Returns:
        An absolute path.

    Raises:
        UsageError: There is no such file; says where it was looked for.
    """
    scheme, separator, rest = name.rpartition("://")
    if separator and scheme not in {"package", "model", "file"}:
        raise UsageError(f"has the mesh '{name}': allowed are paths, package://, model:// and file://. Change it.")
    folder = folder.absolute()
    if scheme in {"package", "model"}:
        tails = [rest, *rest.split("/", 1)[1:]]
        places = [around / tail for around in (folder, *folder.parents) for tail in tails]
    else:
        places = [folder / rest]
    for place in places:
        if place.is_file():
            return place
    raise UsageError(
        f"has the mesh '{name}', and there is no file '{places[0]}'"
        f"{', nor one in the folders around it' if len(places) > 1 else ''}. "
        "Put it there, or take its <visual> or <collision> out of the URDF."
    )


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
        path: An STL file, binary or text, or a Wavefront OBJ, whose objects are taken as one.

    Raises:
        UsageError: The file cannot be read, is of another format, or holds no points that are finite.
    """
    if not is_readable(path):
        raise UsageError(f"'{path}' is no STL or OBJ file. Convert it: other meshes cannot be collided with.")
    try:
        return _read(path, path.stat().st_mtime_ns)
    except (OSError, ValueError) as error:
        raise UsageError(f"'{path}' cannot be read as a mesh ({error}). Export it again.") from error


@lru_cache(maxsize=128)
def _read(path: Path, modified: int) -> Mesh:
    """The surface in a file that was `modified` then: an arm is read several times, and its meshes take longest."""
    mesh = READERS[path.suffix.lower()](path.read_bytes())
    if not mesh.vertices.size or not np.isfinite(mesh.vertices).all():
        raise ValueError("it holds no points, or some that are not finite")
    if mesh.faces.size and not 0 <= mesh.faces.min() <= mesh.faces.max() < len(mesh.vertices):
        raise ValueError("it has triangles with corners that it does not have")
    mesh.vertices.flags.writeable = mesh.faces.flags.writeable = False
    return mesh


def is_readable(path: Path) -> bool:
    """Whether a file is of a format that `read_mesh` knows."""
    return path.suffix.lower() in READERS


def _read_stl(data: bytes) -> Mesh:
    corners = _corners_of_binary(data) if _is_binary_stl(data) else _rows(data, b"vertex")
    if len(corners) % 3:
        raise ValueError("its last triangle is not complete")
    vertices, numbers = np.unique(corners, axis=0, return_inverse=True)
    faces = numbers.reshape(-1, 3).astype(np.int32)
    first, second, third = faces.T
    return Mesh(vertices, faces[(first != second) & (second != third) & (third != first)])


def _is_binary_stl(data: bytes) -> bool:
    # In a text the four bytes of the count are letters, which make a number that no file is long enough for.
    return len(data) >= HEADER + _count_of(data) * TRIANGLE.itemsize


def _corners_of_binary(data: bytes) -> Float:
    triangles = np.frombuffer(data, TRIANGLE, count=_count_of(data), offset=HEADER)
    corners: Float = triangles["corners"].reshape(-1, 3).astype(np.float64)
    return corners


def _count_of(data: bytes) -> int:
    return int.from_bytes(data[HEADER - 4 : HEADER], "little")


def _read_obj(data: bytes) -> Mesh:
    vertices, faces = _rows(data, b"v"), []
    for line in re.findall(rb"^f[ \t]+(.+)$", data, re.MULTILINE):
        first, *others = (int(corner.partition(b"/")[0]) for corner in line.split())
        faces += [(first, one, next_one) for one, next_one in pairwise(others)]  # a polygon is a fan of triangles
    numbers = np.array(faces, dtype=np.int32).reshape(-1, 3)
    # They begin with 1; what is below 0 is counted from the end, as most files with it list all points first.
    return Mesh(vertices, np.where(numbers < 0, numbers + len(vertices), numbers - 1))


def _rows(data: bytes, word: bytes) -> Float:
    """The three numbers behind `word` in each line that begins with it; more than three are left."""
    lines = re.findall(rb"^[ \t]*" + word + rb"[ \t]+(.+)$", data, re.MULTILINE)
    return np.array([line.split()[:3] for line in lines], dtype=np.float64).reshape(-1, 3)


READERS: Mapping[str, Callable[[bytes], Mesh]] = {".stl": _read_stl, ".obj": _read_obj}
"""By the suffix of the file's name, in small letters."""
