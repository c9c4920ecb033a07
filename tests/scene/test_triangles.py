"""Surfaces of triangles."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harness.robot.meshes import Mesh
from harness.scene.scene import AROUND, fewer, surface

SHARE = AROUND / (2 * np.pi) * np.sin(2 * np.pi / AROUND)
"""Of a circle's area that a regular polygon in it has."""


def volume(mesh):
    """Positive where all triangles are counter-clockwise from outside and nothing is open."""
    first, second, third = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    return float((first * np.cross(second, third)).sum()) / 6


@pytest.mark.parametrize(
    ("kind", "size", "expected"),
    [
        ("box", (0.1, 0.2, 0.3), 0.006),
        ("cylinder", (0.1, 0.5), SHARE * np.pi * 0.01 * 0.5),
    ],
)
def test_a_surface_encloses_its_shape(kind, size, expected):
    """Its volume is that of the shape, all corners in the order that is seen from outside."""
    assert volume(surface(kind, size)) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("kind", "size", "exact"),
    [
        ("sphere", (0.1,), 4 / 3 * np.pi * 1e-3),
        ("capsule", (0.1, 0.4), 4 / 3 * np.pi * 1e-3 + np.pi * 0.01 * 0.4),
    ],
)
def test_a_round_surface_is_nearly_its_shape(kind, size, exact):
    """Balls lack a few per cent, and are nowhere larger than they should be."""
    assert 0.94 * exact < volume(surface(kind, size)) < exact


def test_a_capsule_is_as_long_as_its_cylinder_and_two_half_balls():
    """Along z; across it is the radius."""
    low, high = surface("capsule", (0.1, 0.4)).vertices.min(axis=0), surface("capsule", (0.1, 0.4)).vertices.max(axis=0)
    assert_allclose([low[2], high[2], high[0]], [-0.3, 0.3, 0.1])


def test_a_fine_mesh_gets_fewer_triangles_and_keeps_its_shape():
    """Of 2,304 triangles of a ball 500 are left; its volume and its extent stay nearly the same."""
    angles = np.linspace(0, np.pi, 25)
    turns = np.linspace(0, 2 * np.pi, 49)[:-1]
    points = np.array([[np.sin(a) * np.cos(t), np.sin(a) * np.sin(t), np.cos(a)] for a in angles for t in turns])
    faces = [
        triangle
        for ring in range(24)
        for at in range(48)
        for here, after in [(48 * ring + at, 48 * ring + (at + 1) % 48)]
        for triangle in ((here, here + 48, after), (after, here + 48, after + 48))
    ]
    ball = Mesh(points, np.array(faces, np.int32))
    simpler = fewer(ball, 500)
    assert 100 < len(simpler.faces) <= 500
    assert volume(simpler) == pytest.approx(volume(ball), rel=0.1)
    assert_allclose(np.abs(simpler.vertices).max(axis=0), 1.0, atol=0.1)


def test_a_mesh_of_few_triangles_stays_as_it_is():
    """Nothing is lost where nothing has to be."""
    box = surface("box", (1.0, 1.0, 1.0))
    assert fewer(box, 12) is box
