"""The file that Bullet reads an arm from: its URDF, with the harness's solids in the place of meshes.

Bullet's own reader drops a text STL and many an OBJ without an error, takes every object of an OBJ for a solid of its
own, obeys attributes of a <collision> that no other reader knows, and refuses a URDF with a drawing in a format that it
does not know.
"""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from harness import Float
from harness.robot import Robot, Shape, read_mesh


@contextmanager
def file_of_arm(robot: Robot, *, is_drawn: bool = False) -> Iterator[Path]:
    """Within this block, the path of a URDF for Bullet.

    Args:
        robot: The arm.
        is_drawn: Whether its drawings stay in it.
    """
    urdf = ElementTree.fromstring(robot.urdf)
    ElementTree.indent(urdf)  # Bullet breaks lines at 8,191 characters, within names too
    with tempfile.TemporaryDirectory() as folder:
        for link in urdf.iter("link"):
            for visual in link.findall("visual"):
                if is_drawn:
                    _set_surface(visual, Path(folder))
                else:
                    link.remove(visual)
            for collision, solid in zip(
                link.findall("collision"), robot.link_shapes[link.get("name", "")], strict=True
            ):
                _set_solid(collision, solid, Path(folder))
        path = Path(folder, "robot.urdf")
        path.write_text(ElementTree.tostring(urdf, encoding="unicode"), encoding="utf-8")
        yield path


def _set_surface(visual: Element, folder: Path) -> None:
    """Write a drawing anew, as the harness reads it, unless it is an OBJ, which may have colours."""
    mesh = visual.find("geometry/mesh")
    if mesh is not None and not mesh.get("filename", "").lower().endswith(".obj"):
        surface = read_mesh(Path(mesh.get("filename", "")))
        mesh.set("filename", _write_stl(surface.vertices[surface.faces], folder))


def _set_solid(collision: Element, solid: Shape, folder: Path) -> None:
    """Let a <collision> say what its solid is, and where, and no more."""
    for attribute in set(collision.attrib) - {"name"}:
        del collision.attrib[attribute]
    mesh = collision.find("geometry/mesh")
    if mesh is not None and Path(mesh.get("filename", "")).is_file():  # else Bullet says that there is none
        # Bullet takes the convex hull of the corners, whichever triangles they are in. The last ones may come again.
        corners = np.resize(solid.points, (-(-len(solid.points) // 3), 3, 3))
        mesh.attrib = {"filename": _write_stl(corners, folder)}


def _write_stl(corners: Float, folder: Path) -> str:
    """Write triangles, (count, 3, 3), [m], as a new binary STL; its path."""
    triangles = np.zeros(len(corners), "12<f4, <u2")  # normal and corners, an attribute
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # Bullet draws what has no normals black.
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    triangles["f0"] = np.hstack([normals, corners.reshape(-1, 9)])
    path, count = folder / f"{len(list(folder.iterdir()))}.stl", len(corners).to_bytes(4, "little")
    path.write_bytes(bytes(80) + count + triangles.tobytes())
    return str(path)
