"""Writes the meshes of the arm: prisms with rounded ends, as binary STL, [m]. Their files are committed."""

import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

MESHES = Path(__file__).parent / "mesh_arm" / "arm" / "meshes"
SIDES = 12


def link(length: float, radius: float, end_radius: float, width: float) -> NDArray[np.float64]:
    """Points of a bar from the origin along z, (n, 3): half a disc about y at either end, `width` wide along y."""
    angles = np.linspace(0.0, np.pi, SIDES)
    disc = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    outline = np.concatenate([radius * -disc, [0.0, length] + end_radius * disc])
    half = np.full(len(outline), width / 2.0)
    return np.concatenate([np.stack([outline[:, 0], side * half, outline[:, 1]], axis=1) for side in (-1.0, 1.0)])


def pedestal(height: float, radius: float, top_radius: float) -> NDArray[np.float64]:
    """Points of a cone without its tip, standing on z = 0, (n, 3)."""
    angles = np.linspace(0.0, 2.0 * np.pi, 2 * SIDES, endpoint=False)
    ring = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
    return np.concatenate([radius * ring, top_radius * ring + [0.0, 0.0, height]])


def write_stl(path: Path, points: NDArray[np.float64]) -> None:
    """The convex hull of points as binary STL, normals outwards."""
    hull = ConvexHull(points)
    triangles = points[hull.simplices].astype(np.float32)
    normals = hull.equations[:, :3].astype(np.float32)
    turned = np.einsum("ij,ij->i", np.cross(*np.diff(triangles, axis=1).swapaxes(0, 1)), normals) < 0.0
    triangles[turned] = triangles[turned, ::-1]
    rows = [
        struct.pack("<12fH", *normal, *triangle.ravel(), 0) for normal, triangle in zip(normals, triangles, strict=True)
    ]
    path.write_bytes(b"mesh-arm".ljust(80) + struct.pack("<I", len(rows)) + b"".join(rows))


if __name__ == "__main__":
    MESHES.mkdir(parents=True, exist_ok=True)
    write_stl(MESHES / "base.stl", pedestal(0.18, 0.14, 0.09))
    write_stl(MESHES / "shoulder.stl", link(0.12, 0.085, 0.085, 0.14))
    write_stl(MESHES / "upper.stl", link(0.42, 0.07, 0.055, 0.09))
    write_stl(MESHES / "fore.stl", link(0.34, 0.055, 0.04, 0.07))
    write_stl(MESHES / "wrist.stl", link(0.08, 0.035, 0.03, 0.05))
    write_stl(MESHES / "hand.stl", link(0.06, 0.03, 0.02, 0.08))
