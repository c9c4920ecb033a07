"""How far an arm's shapes are from obstacles, held against points on their surfaces."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.linalg import norm
from numpy.random import default_rng

from harness.conditions.clearance import Clearance
from harness.conditions.obstacles import NUMBERS, distance_from
from harness.robot import Shape, link_frames
from tests.registered import FD100 as ARM

SHAPES = {
    "box": (0.2, 0.1, 0.3),
    "cylinder": (0.08, 0.3),
    "capsule": (0.05, 0.3),
    "sphere": (0.07,),
}
TURNED = np.array([[0.0, -1.0, 0.0, 0.05], [0.6, 0.0, -0.8, 0.02], [0.8, 0.0, 0.6, 0.1], [0.0, 0.0, 0.0, 1.0]])
SPHERE = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.06]
BOX = [0.0, 0.0, 0.0, 0.05, 0.12, 0.08, 0.0]


def arm_with(kind):
    """The FD100 with one shape at its last link."""
    points = np.empty((0, 3))
    if kind == "mesh":
        points = np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.05, 0.05) for z in (-0.15, 0.15)])
    shape = Shape(kind, SHAPES.get(kind, ()), TURNED, points)
    return replace(ARM, joint_shapes=((),) * 5 + ((shape,),))


def points_in(kind, rng, count=4000):
    """Points of the shape in its own frame, most of them on its surface."""
    size = np.array(SHAPES.get(kind, SHAPES["box"]))
    if kind in ("box", "mesh"):
        return np.clip(rng.uniform(-1.5, 1.5, (count, 3)), -1.0, 1.0) * size / 2.0
    direction = rng.normal(size=(count, 3))
    direction /= norm(direction, axis=1)[:, None]
    if kind == "sphere":
        return direction * size[0]
    along = np.clip(rng.uniform(-1.5, 1.5, count), -1.0, 1.0) * size[1] / 2.0
    if kind == "capsule":
        return direction * size[0] + along[:, None] * [0.0, 0.0, 1.0]
    round_ = rng.uniform(0.0, 2.0 * np.pi, count)
    radius = size[0] * np.minimum(1.0, np.sqrt(rng.uniform(0.0, 1.5, count)))
    return np.stack([radius * np.cos(round_), radius * np.sin(round_), along], axis=1)


@pytest.mark.parametrize("obstacle", [SPHERE, BOX], ids=["sphere", "box"])
@pytest.mark.parametrize("kind", [*SHAPES, "mesh"])
def test_distance_is_that_of_the_nearest_points(kind, obstacle):
    """For every kind of shape and obstacle: no point is nearer, and some point is about as near."""
    rng, arm = default_rng(0), arm_with(kind)
    qpos = rng.uniform(arm.lower, arm.upper, (12, arm.dof))
    obstacles = np.tile(obstacle, (12, 1, 1))
    obstacles[:, 0, :3] = arm.end_effector(qpos) + rng.uniform(-0.5, 0.5, (12, 3))
    found = Clearance(arm).distance(qpos, obstacles)
    frames = np.moveaxis(link_frames(arm.chain, qpos)[-1], -1, 0)  # (n, 3, 4)
    inside = points_in(kind, rng) @ TURNED[:3, :3].T + TURNED[:3, 3]
    for pose in range(12):
        nearest = distance_from(inside @ frames[pose, :, :3].T + frames[pose, :, 3], obstacles[pose, 0]).min()
        if nearest > 0.01:
            assert nearest - 0.012 < found[pose] < nearest + 1e-5
        else:
            assert found[pose] < nearest + 1e-5


def test_touching_is_being_within_the_clearance():
    """Just within the distance it is touched, just without it is not; the answer does not depend on the batch."""
    rng, clearance = default_rng(1), Clearance(ARM)
    qpos = rng.uniform(ARM.lower, ARM.upper, (40, 6))
    obstacles = np.array([SPHERE, BOX])[None].repeat(40, axis=0)
    obstacles[..., :3] = rng.uniform([-1.0, -1.0, 0.3], [1.0, 1.0, 1.2], (40, 2, 3))
    distance = clearance.distance(qpos, obstacles)
    apart = distance > 0.01
    assert 10 < apart.sum() < 40
    for pose in np.flatnonzero(apart):
        one = (qpos[pose : pose + 1], obstacles[pose : pose + 1])
        assert clearance.touches(*one, float(distance[pose]) + 1e-4).all()
        assert not clearance.touches(*one, float(distance[pose]) - 1e-4).any()
        assert clearance.distance(*one)[0] == distance[pose]


def test_nothing_is_touched_where_there_is_no_obstacle():
    """Seven zeros are none."""
    qpos, none = ARM.home[None], np.zeros((1, 2, NUMBERS))
    assert not Clearance(ARM).touches(qpos, none, 10.0)[0]
    assert Clearance(ARM).distance(qpos, none)[0] == np.inf


def test_an_arm_around_a_box_touches_it_without_clearance():
    """Cores that overlap are at distance 0, which counts."""
    box = np.array([[[*ARM.end_effector(ARM.home), 0.02, 0.02, 0.02, 0.0]]])
    assert Clearance(ARM).touches(ARM.home[None], box, 0.0)[0]
