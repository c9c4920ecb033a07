"""What is drawn of a robot."""

import numpy as np
import pytest
from numpy.linalg import norm
from numpy.random import default_rng
from numpy.testing import assert_allclose

from harness.robot.kinematics import child_frames, end_effector_position
from harness.scene.picture import chain_of, corners_of
from harness.scene.scene import FEWEST, GREY, TRIANGLES, scene_of
from tests.registered import FD100
from tests.scene.conftest import meshed

RNG = default_rng(5)


def test_the_tip_of_the_drawn_arm_is_the_robots(robot, scene):
    """What was written moves as the robot does, in any pose."""
    poses = RNG.uniform(robot.lower, robot.upper, (50, robot.dof))
    assert_allclose(end_effector_position(chain_of(scene), poses), robot.end_effector(poses), atol=1e-12)


def test_triangles_move_with_their_joint(robot, scene):
    """Each body keeps its place in its joint's frame; what no joint moves stands still."""
    poses = RNG.uniform(robot.lower, robot.upper, (2, robot.dof))
    joints = np.concatenate([[body.joint] * len(body.faces) for body in scene.bodies]).astype(int)
    local = []
    for pose in poses:
        frames = np.stack([np.eye(4), *child_frames(robot.chain, pose)])
        corners, _ = corners_of(scene, pose)
        inverse = np.linalg.inv(frames)[joints + 1]
        local.append(np.einsum("tij,tkj->tki", inverse[:, :3, :3], corners) + inverse[:, None, :3, 3])
    assert_allclose(local[0], local[1], atol=1e-9)


def test_the_drawn_fd100_lies_where_its_shapes_are():
    """Its hand is drawn around the end effector, and its foot stands on the ground."""
    corners, _ = corners_of(scene_of(FD100), FD100.home)
    assert norm(corners.reshape(-1, 3) - FD100.end_effector(FD100.home), axis=1).min() < 0.05
    assert corners[..., 2].min() == pytest.approx(0.0, abs=1e-9)


def test_every_triangle_faces_outwards(robot, scene):
    """Also those of a mesh that is mirrored: the volume of each body is positive."""
    for body in scene.bodies:
        centred = body.points - body.points.mean(axis=0)
        first, second, third = np.moveaxis(centred[body.faces.astype(int)], 1, 0)
        assert (first * np.cross(second, third)).sum() > 0


def test_colours_are_those_of_the_urdf(tmp_path):
    """A material that stands outside the links counts by its name."""
    assert {body.colour for body in scene_of(meshed(tmp_path)).bodies} == {"#ff0000"}
    assert {body.colour for body in scene_of(FD100).bodies} == {"#33363b", "#ed6b17", "#b8babf"}


def test_what_collides_stands_in_for_a_mesh_that_is_not_read(tmp_path):
    """Of COLLADA nothing is drawn: the ball of that link is, in the colour of its visual shape."""
    scene = scene_of(meshed(tmp_path, ("part.stl", "part.stl", "part.dae", "part.stl")))
    counts = {body.joint: len(body.faces) for body in scene.bodies}
    assert counts[0] == counts[-1] == 12
    assert counts[1] > 100
    assert np.abs(next(body.points for body in scene.bodies if body.joint == 1)).max() == pytest.approx(0.05)


HULL = '<mesh filename="part.stl"/>'


def test_of_a_mesh_that_collides_the_hull_stands_in(tmp_path):
    """Its corners are the mesh's own, and its triangles face outwards."""
    scene = scene_of(meshed(tmp_path, ("part.stl", "part.stl", "part.dae", "part.stl"), HULL))
    body = next(body for body in scene.bodies if body.joint == 1)
    assert len(body.faces) == 12
    assert_allclose(np.ptp(body.points, axis=0), (0.1, 0.05, 0.2), atol=1e-6)
    first, second, third = np.moveaxis(body.points[body.faces.astype(int)], 1, 0)
    assert (first * np.cross(second, third)).sum() / 6 == pytest.approx(0.1 * 0.05 * 0.2, rel=1e-4)


def test_a_flat_mesh_that_collides_is_drawn_as_a_sheet(tmp_path):
    """As thick as engines have it."""
    scene = scene_of(meshed(tmp_path, ("part.stl", "part.stl", "part.dae", "part.stl"), '<mesh filename="flat.stl"/>'))
    assert {body.joint: len(body.faces) for body in scene.bodies} == {-1: 12, 0: 12, 1: 12, 2: 12}


def test_what_collides_stands_in_for_an_empty_mesh(tmp_path):
    """A file without triangles is drawn as little as one that is not read."""
    scene = scene_of(meshed(tmp_path, ("part.stl", "part.stl", "empty.stl", "part.stl"), HULL))
    assert [len(body.faces) for body in scene.bodies if body.joint == 1] == [12]


def test_what_has_no_colour_is_grey(tmp_path_factory, subtests):
    """No material, one that the URDF does not have, or one whose colour is none."""
    rows = [
        ("", GREY),
        ('<material name="blue"/>', GREY),
        ('<material name="own"><color rgba="0 0.5 1 1"/></material>', "#0080ff"),
        ('<material name="own"><color rgba="sky blue"/></material>', GREY),
        ('<material name="own"><color rgba="2 0 0 1"/></material>', GREY),
        ('<material name="own"><color rgba="nan 0 0 1"/></material>', GREY),
    ]
    for material, colour in rows:
        with subtests.test(material=material):
            tmp_path = tmp_path_factory.mktemp("case")
            assert {body.colour for body in scene_of(meshed(tmp_path, material=material)).bodies} == {colour}


def test_an_arm_has_so_many_triangles_at_most(robot, scene):
    """A page of several arms stays small."""
    assert sum(len(body.faces) for body in scene.bodies) <= TRIANGLES
    assert FEWEST * 1_000 <= 50_000, "else an arm of the most shapes that are read could not be written"
