"""Surfaces made of triangles: those of the shapes that a URDF has, and of meshes with fewer triangles."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.robot.meshes import Mesh
from harness.robot.shapes import ShapeKind

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
    return Mesh(_rounded(points), np.concatenate(faces).astype(np.int32))


def _rounded(points: Float) -> Float:
    return np.round(points, 12)
