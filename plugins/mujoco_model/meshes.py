"""The meshes of an arm in a MuJoCo model, added by hand.

MuJoCo's own reader of URDFs has four faults. It cuts the folders off mesh paths, takes two files of one name for one
mesh, stops at a format that it does not know, and draws only one object of an OBJ file that has several.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import mujoco
import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.robot.meshes import is_readable, read_mesh
from harness.robot.shapes import Shape, read_origin, read_scale

GREY = [0.7, 0.7, 0.7, 1.0]
"""Red, green, blue and opacity, 0 to 1, of a surface without a colour."""
COLOR = re.compile(r"(\s*(\d+\.?\d*|\.\d+)(?=\s|$)){4}\s*")
"""Matches four numbers with spaces between them."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A surface that is drawn and touches nothing.

    Attributes:
        vertices: In the mesh's frame, scaled, shape (count, 3), [m].
        faces: Numbers of each triangle's corners, shape (triangles, 3).
        pose: T_link_mesh, shape (4, 4).
        color: Red, green, blue and opacity, 0 to 1.
    """

    vertices: Float
    faces: NDArray[np.int32]
    pose: Float
    color: list[float]


def without_meshes(urdf: Element) -> str:
    """The text of a URDF without the shapes that are meshes; the element `urdf` itself is left as it is."""
    robot = deepcopy(urdf)
    for link in robot.iter("link"):
        for shape in [*link.findall("collision"), *link.findall("visual")]:
            if shape.find("geometry/mesh") is not None:
                link.remove(shape)
    return ElementTree.tostring(robot, encoding="unicode")


def add_meshes(spec: mujoco.MjSpec, urdf: Element, link_shapes: Mapping[str, Sequence[Shape]]) -> None:
    """Add the shapes that `without_meshes` left out: convex hulls that collide, and surfaces to be seen.

    Args:
        spec: The arm without meshes.
        urdf: The element `<robot>` of the arm's URDF.
        link_shapes: As in `harness.robot.Robot`.
    """
    bodies = {body.name: body for body in spec.bodies}
    surfaces = _read_surfaces(urdf)
    for link, shapes in link_shapes.items():
        body = bodies.get(link, spec.worldbody)  # the root link has become the world
        for shape in (shape for shape in shapes if shape.kind == "mesh"):
            mesh = _new_mesh(spec, f"collision of link {link}", uservert=shape.points.ravel())
            geom = _add_geom(body, mesh, shape.T_link_shape)
            geom.group = 3 if surfaces[link] else 0  # drawn only if the link has no surface
        for surface in surfaces[link]:
            _add_surface(spec, body, link, surface)


def _read_surfaces(urdf: Element) -> dict[str, list[Surface]]:
    """The surfaces of each link. Formats other than STL and OBJ are left out."""
    colors = dict(_colors(urdf))
    return {link.get("name", ""): list(_surfaces(link, colors)) for link in urdf.findall("link")}


def _surfaces(link: Element, colors: dict[str, list[float]]) -> Iterator[Surface]:
    owner = f"Link '{link.get('name')}'"
    for visual in link.findall("visual"):
        mesh, material = visual.find("geometry/mesh"), visual.find("material")
        path = Path("" if mesh is None else mesh.get("filename", ""))
        if mesh is not None and is_readable(path):
            name = "" if material is None else material.get("name", "")
            vertices = read_mesh(path).vertices * read_scale(mesh, owner)
            yield Surface(vertices, read_mesh(path).faces, read_origin(visual, owner), colors.get(name, GREY))


def _colors(robot: Element) -> Iterator[tuple[str, list[float]]]:
    """Named materials and their colours: red, green, blue and opacity. A malformed colour is left out."""
    for material in robot.iter("material"):
        color = material.find("color")
        words = "" if color is None else color.get("rgba", "")
        if COLOR.fullmatch(words):
            yield material.get("name", ""), [float(word) for word in words.split()]


def _add_surface(spec: mujoco.MjSpec, body: Any, link: str, surface: Surface) -> None:
    name = f"visual of link {link}"
    mesh = _new_mesh(spec, name, uservert=surface.vertices.ravel(), userface=surface.faces.ravel())
    spec.mesh(mesh).inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # the surface may be open
    geom = _add_geom(body, mesh, surface.pose)
    geom.contype = geom.conaffinity = 0
    geom.group, geom.rgba = 1, surface.color


def _new_mesh(spec: mujoco.MjSpec, what: str, **settings: Any) -> str:
    """Add a mesh, and its name, which MuJoCo's errors tell; a number in it makes it the only one."""
    name = f"{what} (mesh {len(spec.meshes) + 1})"
    spec.add_mesh(name=name, **settings)
    return name


def _add_geom(body: Any, mesh: str, pose: Float) -> Any:
    """Add a mesh to a link, at `pose` in the link's frame, (4, 4), [m]."""
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, pose[:3, :3].ravel())
    return body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh, pos=pose[:3, 3], quat=quat)
