"""Pictures of an arm."""

import numpy as np
from numpy.testing import assert_allclose

from harness.record.scene import Scene
from harness.scene.picture import BACKGROUND, camera_for, corners_of, draw_arm, draw_still
from harness.simulator import Camera

HOMELESS = np.empty((0, 3))


def test_the_camera_puts_its_centre_into_the_middle():
    """What is right of it is on the right, what is above is above."""
    camera = Camera(np.array([0.1, 0.2, 0.3]), 1.0, 300, 200)
    column, row, _ = camera.project(camera.centre)
    right, up, back = camera.axes
    assert_allclose((column, row), (150, 100))
    assert camera.project(camera.centre + 0.1 * right)[0] > column
    assert camera.project(camera.centre + 0.1 * up)[1] < row
    assert camera.project(camera.centre + 0.1 * back)[2] < camera.project(camera.centre)[2]


def test_the_arm_is_seen_where_its_end_effector_is(robot, scene):
    """The picture with the arm differs from the one without, around the end effector too."""
    tip = robot.end_effector(robot.home)
    camera = camera_for(corners_of(scene, robot.home)[0].reshape(-1, 3), 320, 240)
    empty = Scene(scene.robot, scene.joints, scene.tip, ())
    target = np.array([0.0, 0.0, -9.0])
    shown, bare = (np.asarray(draw_arm(it, robot.home, target, HOMELESS, BACKGROUND, camera)) for it in (scene, empty))
    assert shown.shape == (240, 320, 3)
    column, row = (round(float(number)) for number in camera.project(tip)[:2])
    near = np.s_[row - 8 : row + 8, column - 8 : column + 8]
    assert (shown[near] != bare[near]).any()
    assert 0.01 < (shown != bare).any(axis=2).mean() < 0.7


def test_a_still_picture_shows_the_target(robot, scene):
    """Another target, another picture."""
    tip = robot.end_effector(robot.home)
    one, other = (np.asarray(draw_still(scene, robot.home, at, 160, 120)) for at in (tip / 2, tip / 3))
    assert (one != other).any()
