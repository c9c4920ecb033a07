"""How low the collision shapes of a chain reach, and the frames that say so."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.robot import (
    Shape,
    build_solids,
    forward,
    link_frames,
    parse_urdf,
)
from harness.robot.kinematics import build_chain, transform
from harness.robot.urdf import read_chain
from tests.refusals import refused

CORNERS = np.array(np.meshgrid([-0.1, 0.1], [-0.2, 0.2], [-0.3, 0.3])).reshape(3, -1).T
"""Of a box of 0.2 x 0.4 x 0.6."""


@pytest.fixture(scope="module")
def chain(arm_text):
    """Three joints: one that turns, one that slides, one that turns."""
    return build_chain(read_chain(parse_urdf(arm_text), "tip"))


@pytest.fixture(scope="module")
def solids(attached):
    """The shapes of the arm as arrays."""
    return build_solids(attached)


def random_joints(count, dof=3):
    """Joint positions, (count, dof)."""
    return default_rng(3).uniform(-3.0, 3.0, (count, dof))


def rotations(count):
    """Frames with random orientation at the origin, as of one joint, (1, 3, 4, count)."""
    matrices, _ = np.linalg.qr(default_rng(5).normal(size=(count, 3, 3)))
    return np.concatenate([matrices, np.zeros((count, 3, 1))], axis=2).transpose(1, 2, 0)[None]


def one(kind, *size):
    """A shape alone, at the origin of the only joint's frame."""
    return build_solids([[Shape(kind, size, np.eye(4))]])


def test_frames_are_those_of_the_kinematics(chain):
    """The last frame, with the constant step to the tip, is the tip's pose; each other one that of a shorter chain."""
    qpos = random_joints(50)
    frames = link_frames(chain, qpos)
    assert frames.shape == (3, 3, 4, 50)
    for count in (1, 2, 3):
        part = type(chain)(chain.T_previous_joint[:count], chain.axes[:count], chain.kinds[:count], np.eye(4))
        expected = forward(part, qpos[:, :count])[:, :3]
        assert_allclose(frames[count - 1].transpose(2, 0, 1), expected, atol=1e-14)


@pytest.mark.parametrize("count", [1, 2, 3, 7, 16])
def test_frames_do_not_depend_on_the_batch(chain, count):
    """A pose's frames are, bit for bit, those that it has among a thousand others."""
    qpos = random_joints(1000)
    many = link_frames(chain, qpos)
    for start in range(0, 900, 131):
        assert_array_equal(link_frames(chain, qpos[start : start + count]), many[..., start : start + count])


def test_frames_of_the_wrong_number_of_joints_are_refused(chain):
    """One value too many is a UsageError."""
    with refused("Give one value per joint"):
        link_frames(chain, np.zeros((5, 4)))


@pytest.mark.parametrize(
    ("solids", "flat", "upright"),
    [
        (one("box", 0.2, 0.4, 0.6), 0.1, 0.3),
        (one("cylinder", 0.2, 0.6), 0.2, 0.3),
        (one("capsule", 0.2, 0.6), 0.2, 0.5),
        (one("sphere", 0.2), 0.2, 0.2),
    ],
)
def test_lowest_point_where_it_is_known(solids, flat, upright):
    """Upright, and lying with its x axis down, each shape reaches as low as its size says, below its height of 1 m."""
    lying = [[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 1.0]]
    standing = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 1.0]]
    frames = np.moveaxis(np.array([lying, standing]), 0, -1)[None]
    assert_allclose(solids.lowest(frames), [1.0 - flat, 1.0 - upright], atol=1e-15)


def test_lowest_point_of_a_box_is_a_corner():
    """In any orientation of the link, wherever in the link the box is."""
    frames, pose = rotations(200), transform((0.5, -0.6, 0.7), (0.4, 0.5, 0.6))
    in_link = pose[:3, :3] @ CORNERS.T + pose[:3, 3:]
    heights = np.einsum("kn,kc->nc", frames[0, 2, :3], in_link).min(axis=1)
    box = build_solids([[Shape("box", (0.2, 0.4, 0.6), pose)]])
    assert_allclose(box.lowest(frames), heights, atol=1e-14)


@pytest.mark.parametrize(("kind", "ball"), [("cylinder", 0.0), ("capsule", 0.2)])
def test_lowest_point_of_a_round_shape_is_on_its_rims(kind, ball):
    """In any orientation: on a cylinder's rims, and a ball's radius below the ends of a capsule."""
    frames, angle = rotations(200), np.linspace(0.0, 2.0 * np.pi, 2000)
    rim = (0.2 - ball) * np.array([np.cos(angle), np.sin(angle)])
    ends = np.concatenate([np.vstack([rim, np.full_like(angle, end)]) for end in (-0.3, 0.3)], axis=1)
    heights = np.einsum("kn,kc->nc", frames[0, 2, :3], ends).min(axis=1) - ball
    assert_allclose(one(kind, 0.2, 0.6).lowest(frames), heights, atol=1e-6)


def test_chain_reaches_as_low_as_the_lowest_of_its_shapes(chain, attached, solids):
    """All shapes together reach as low as the lowest one alone, each on its own joint."""
    frames = link_frames(chain, random_joints(300))
    alone = [
        build_solids([[shape] if number == frame else [] for number in range(3)]).lowest(frames)
        for frame, shapes in enumerate(attached)
        for shape in shapes
    ]
    assert_array_equal(solids.lowest(frames), np.min(alone, axis=0))
    assert set(np.argmin(alone, axis=0)) >= {1, 2, 3}  # one at least of each joint


def test_bounds_skip_nothing_that_touches(chain, solids):
    """The ground is touched exactly where the lowest point is below it, at any height of the arm."""
    frames = link_frames(chain, random_joints(2000))
    frames[:, 2, 3] += default_rng(7).uniform(-0.5, 1.5, 2000)
    touching = solids.touch_ground(frames)
    assert_array_equal(touching, solids.lowest(frames) < 0.0)
    assert 200 < touching.sum() < 1800


def test_without_shapes_nothing_touches(chain):
    """An arm without shapes has no lowest point."""
    solids = build_solids([[], [], []])
    frames = link_frames(chain, random_joints(4))
    assert not solids.touch_ground(frames).any()
    assert_array_equal(solids.lowest(frames), np.inf)


@pytest.mark.parametrize("pose", [np.eye(4), transform((0.5, -0.6, 0.7), (0.4, 0.5, 0.6))])
def test_mesh_reaches_as_low_as_the_box_that_it_is(pose):
    """The corners of a box as a mesh reach exactly as low as the box, wherever in the link it is."""
    mesh = build_solids([[Shape("mesh", (), pose, CORNERS)]])
    box = build_solids([[Shape("box", (0.2, 0.4, 0.6), pose)]])
    frames = rotations(200)
    assert_allclose(mesh.lowest(frames), box.lowest(frames), atol=1e-14)


def test_mesh_touches_where_its_lowest_point_is_below_the_ground(chain, attached):
    """Meshes count beside other shapes, on any joint, also with more points than are computed at once."""
    cloud = default_rng(2).normal(size=(700, 3)) * 0.2
    mesh = Shape("mesh", (), np.eye(4), cloud)
    solids = build_solids([[], [mesh, replace(mesh, points=cloud + 0.1)], list(attached[2])])
    frames = link_frames(chain, random_joints(500))
    frames[:, 2, 3] += default_rng(7).uniform(-0.5, 2.0, 500)
    both = np.concatenate([cloud, cloud + 0.1])
    heights = np.einsum("kn,ck->nc", frames[1, 2, :3], both).min(axis=1) + frames[1, 2, 3]
    expected = np.minimum(heights, build_solids([[], [], attached[2]]).lowest(frames))
    assert_allclose(solids.lowest(frames), expected, atol=1e-14)
    assert_array_equal(solids.touch_ground(frames), expected < 0.0)
    assert 50 < (expected < 0.0).sum() < 450
