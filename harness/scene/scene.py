"""From a robot to what is drawn of it."""

from collections import defaultdict
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple, cast
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import UsageError
from harness.record.scene import Body, Scene, SceneJoint
from harness.robot.meshes import Mesh
from harness.robot.robot import Robot
from harness.robot.shapes import SIZES, Shape, ShapeKind, moving_carrier, read_origin, read_sizes, read_surface
from harness.robot.urdf import parse_urdf

AROUND = 24
"""Corners of a circle."""
RINGS = 5
"""The rings of a half sphere."""
FINEST = 96
"""Cells of the grid along the longest side of a mesh, to begin with."""


def surface(kind: ShapeKind, size: Sequence[float]) -> Mesh:
    """The surface of a box, cylinder, capsule or sphere, corners counter-clockwise from outside.

    Args:
        kind: Which, no mesh.
        size: As `harness.robot.shapes.Shape.size`, [m].

    Returns:
        In the shape's frame, [m].
    """
    if kind == "box":
        return _box(size)
    if kind == "cylinder":
        radius, half = size[0], size[1] / 2
        return _turned([(0.0, -half), (radius, -half), (radius, -half), (radius, half), (radius, half), (0.0, half)])
    radius, half = size[0], (size[1] / 2 if kind == "capsule" else 0.0)
    angles = np.linspace(-np.pi / 2, 0.0, RINGS + 1)
    lower = [(radius * np.cos(angle), radius * np.sin(angle) - half) for angle in angles]
    return _turned([*lower, *((across, -height) for across, height in reversed(lower))])


def fewer(mesh: Mesh, most: int) -> Mesh:
    """The mesh with `most` triangles or fewer: points that share a cell of a grid become one, their mean.

    The grid grows coarser until it is so. This is vertex clustering (Rossignac and Borrel 1993).
    """
    simpler, cells = mesh, FINEST
    while len(simpler.faces) > most and cells > 0:
        simpler, cells = _clustered(mesh, cells), cells * 3 // 4
    return simpler


def _clustered(mesh: Mesh, cells: int) -> Mesh:
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    edge = max(float((high - low).max()), 1e-12) / cells
    grid = np.floor((mesh.vertices - low) / edge).astype(np.int64)
    _, number, count = np.unique(grid @ [1, 1 << 20, 1 << 40], return_inverse=True, return_counts=True)
    points = np.stack([np.bincount(number, column) for column in mesh.vertices.T], axis=1) / count[:, None]
    faces = number[mesh.faces].astype(np.int32)
    first, second, third = faces.T
    faces = faces[(first != second) & (second != third) & (third != first)]
    turned = np.take_along_axis(faces, (faces.argmin(axis=1)[:, None] + np.arange(3)) % 3, axis=1)
    return Mesh(points, np.unique(turned, axis=0))


def _box(size: Sequence[float]) -> Mesh:
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return Mesh(corners, np.array([face for a, b, c, d in sides for face in ((a, b, c), (a, c, d))], np.int32))


def _turned(profile: Sequence[tuple[float, float]]) -> Mesh:
    """A profile of (distance from the z axis, height), from below, turned about the z axis."""
    angles = np.arange(AROUND) * 2 * np.pi / AROUND
    circle = np.stack([np.cos(angles), np.sin(angles), np.zeros(AROUND)], axis=1)
    points = np.concatenate([circle * across + [0.0, 0.0, height] for across, height in profile])
    here = np.arange(AROUND)
    after = (here + 1) % AROUND
    faces: list[NDArray[np.intp]] = []
    for ring, ((across, height), (next_across, next_height)) in enumerate(pairwise(profile)):
        low, high = ring * AROUND, (ring + 1) * AROUND
        if (across, height) == (next_across, next_height):
            continue
        if across > 0.0:
            faces.append(np.stack([low + here, low + after, high + after], axis=1))
        if next_across > 0.0:
            faces.append(np.stack([low + here, high + after, high + here], axis=1))
    return Mesh(np.round(points, 12), np.concatenate(faces).astype(np.int32))


TRIANGLES = 16_000
"""The most triangles of an arm: a page with several arms stays small."""
FEWEST = 40
"""The fewest triangles of a shape, where there are very many."""
GREY = "#9aa0a6"
"""The colour of what the URDF gives no colour."""


class Part(NamedTuple):
    """One surface of a link."""

    colour: str
    T_link_shape: Float
    mesh: Mesh


def scene_of(robot: Robot) -> Scene:
    """What is drawn of a robot: the visual shapes of each link, or those that collide.

    The collision shapes of a link stand in where it has no visual shapes.
    Fine surfaces are drawn with fewer triangles, `TRIANGLES` together.

    Args:
        robot: The robot; every link is drawn, those beside the chain too.
    """
    urdf = parse_urdf(robot.urdf)
    colours = {each.get("name", ""): _colour(each) for each in urdf.element.findall("material")}
    shapes = sum(max(len(link.findall("visual")), len(link.findall("collision"))) for link in urdf.links.values())
    budget = max(FEWEST, TRIANGLES // max(1, shapes))
    found: dict[tuple[int, str], list[Mesh]] = defaultdict(list)
    for name, link in urdf.links.items():
        joint, T_child_link = moving_carrier(name, urdf.carriers)
        number = robot.joint_names.index(joint) if joint in robot.joint_names else -1
        for part in _parts(link, robot.link_shapes[name], colours):
            found[number, part.colour].append(_moved(fewer(part.mesh, budget), T_child_link @ part.T_link_shape))
    chain = robot.chain
    return Scene(
        robot.name,
        tuple(
            SceneJoint(frame[:3], axis, bool(slides))
            for frame, axis, slides in zip(chain.T_previous_joint, chain.axes, chain.slides, strict=True)
        ),
        chain.T_last_tip[:3],
        tuple(_body(joint, colour, meshes) for (joint, colour), meshes in found.items()),
    )


def _parts(link: Element, solids: tuple[Shape, ...], colours: dict[str, str]) -> list[Part]:
    """The surfaces of a link."""
    visuals = link.findall("visual")
    try:
        parts = [_visual(visual, colours, f"Link '{link.get('name')}'") for visual in visuals]
    except UsageError:  # of a kind that no engine draws: what collides is drawn
        parts = []
    colour = _colour_of(visuals[0], colours) if visuals else GREY
    return parts or [Part(colour, solid.T_link_shape, _solid(solid)) for solid in solids]


def _visual(visual: Element, colours: dict[str, str], owner: str) -> Part:
    shape = visual.find("geometry/*")
    if shape is None or shape.tag not in SIZES:
        raise UsageError(f"{owner} has a visual that is not drawn")
    kind = cast(ShapeKind, shape.tag)
    if kind == "mesh":
        mesh, T_link_shape = read_surface(visual, owner)
    else:
        mesh, T_link_shape = surface(kind, read_sizes(shape, owner)), read_origin(visual, owner)
    return Part(_colour_of(visual, colours), T_link_shape, mesh)


def _solid(solid: Shape) -> Mesh:
    """The surface of what collides: of a mesh its convex hull."""
    if solid.kind != "mesh":
        return surface(solid.kind, solid.size)
    from scipy.spatial import ConvexHull, QhullError  # which few arms need, and which takes long to import

    try:
        hull = ConvexHull(solid.points)
    except (QhullError, ValueError):  # points of a plane have no inside
        return Mesh(np.empty((0, 3)), np.empty((0, 3), np.int32))
    corners = solid.points[hull.simplices]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = (normals * hull.equations[:, :3]).sum(axis=1) < 0
    faces = np.where(inward[:, None], hull.simplices[:, ::-1], hull.simplices)
    return Mesh(solid.points, faces.astype(np.int32))


def _moved(mesh: Mesh, pose: Float) -> Mesh:
    return Mesh(mesh.vertices @ pose[:3, :3].T + pose[:3, 3], mesh.faces)


def _body(joint: int, colour: str, meshes: list[Mesh]) -> Body:
    """All meshes as one, without points that no triangle has."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)])
    used, numbers = np.unique(faces, return_inverse=True)
    points = np.concatenate([mesh.vertices for mesh in meshes])[used]
    return Body(joint, colour, points, numbers.reshape(-1, 3).astype(np.uint16))


def _colour_of(visual: Element, colours: dict[str, str]) -> str:
    material = visual.find("material")
    if material is None:
        return GREY
    return colours.get(material.get("name", ""), GREY) if material.find("color") is None else _colour(material)


def _colour(material: Element) -> str:
    """A colour as text, ``#rrggbb``; grey if the material names no colour that can be read."""
    colour = material.find("color")
    words = "" if colour is None else colour.get("rgba", "")
    try:
        shares = [float(word) for word in words.split(None, 4)[:3]]
    except ValueError:
        shares = []
    if len(shares) != 3 or not all(0.0 <= share <= 1.0 for share in shares):  # NaN is not either
        return GREY
    return "#" + "".join(f"{round(255 * share):02x}" for share in shares)
