"""Inverse kinematics: what is found is right, and most of what can be reached is found."""

import numpy as np
from numpy.linalg import norm
from numpy.random import default_rng
from numpy.testing import assert_array_equal

from harness.robot import forward, reach_position
from harness.robot.kinematics import reach_pose, rotation_between
from tests.registered import FD100 as ROBOT, UNITY_ARM

COUNT = 200


def near_home():
    """Random poses within 60 degrees of home."""
    noise = default_rng(0).uniform(-np.pi / 3, np.pi / 3, (COUNT, ROBOT.dof))
    return np.clip(ROBOT.home + noise, ROBOT.lower, ROBOT.upper)


def reachable_points():
    """Their end effectors."""
    return ROBOT.end_effector(near_home())


def from_home(points):
    """What is found from the home pose."""
    return reach_position(ROBOT, points, np.tile(ROBOT.home, (len(points), 1)))


def test_found_poses_are_there():
    """Where it says so, the end effector is within the tolerance of the point; where not, it is not."""
    points = np.concatenate([reachable_points(), [[5.0, 0.0, 0.0]]])
    qpos, reached = from_home(points)
    assert_array_equal(reached, norm(ROBOT.end_effector(qpos) - points, axis=1) <= 1e-3)


def test_most_of_what_can_be_reached_is_found():
    """Of 200 points that the arm can reach, at least 95 % are found from home."""
    assert from_home(reachable_points())[1].mean() >= 0.95


def test_found_poses_are_within_the_ranges():
    """No joint is beyond an end of its range, found or not."""
    qpos, _ = from_home(np.concatenate([reachable_points(), [[5.0, 0.0, 0.0], [0.0, 0.0, -3.0]]]))
    assert (qpos >= ROBOT.lower).all()
    assert (qpos <= ROBOT.upper).all()


def test_point_beyond_the_reach_is_not_reached():
    """A point 5 m away is told as not reached."""
    assert not from_home(np.array([[5.0, 0.0, 0.0]]))[1].any()


def test_tighter_tolerance_is_kept():
    """With a tolerance of a micrometre what is found is that close."""
    points = reachable_points()
    qpos, reached = reach_position(ROBOT, points, np.tile(ROBOT.home, (COUNT, 1)), tolerance=1e-6, iterations=200)
    assert reached.mean() >= 0.9
    assert norm(ROBOT.end_effector(qpos) - points, axis=1)[reached].max() <= 1e-6


def test_start_is_left_alone():
    """The poses that the search begins at are not changed."""
    start = np.tile(ROBOT.home, (COUNT, 1))
    reach_position(ROBOT, reachable_points(), start)
    assert_array_equal(start, np.tile(ROBOT.home, (COUNT, 1)))


def test_a_far_target_does_not_throw_the_arm():
    """From its home the unity-arm finds the published target, whose error points far beyond what the Jacobian knows."""
    qpos, reached = reach_position(UNITY_ARM, np.array([[0.45, -0.45, 0.2]]), UNITY_ARM.home[None])
    assert reached.all()
    assert (qpos >= UNITY_ARM.lower).all()
    assert (qpos <= UNITY_ARM.upper).all()


def test_poses_are_found_with_their_orientation():
    """Where it says so, place and orientation are within the tolerances; of poses about home nearly all are found."""
    wanted = forward(ROBOT.chain, near_home())
    start = np.tile(ROBOT.home, (COUNT, 1))
    qpos, reached = reach_pose(ROBOT, wanted[:, :3, 3], wanted[:, :3, :3], start)
    found = forward(ROBOT.chain, qpos)
    way = norm(found[:, :3, 3] - wanted[:, :3, 3], axis=1)
    turn = norm(rotation_between(found[:, :3, :3], wanted[:, :3, :3]), axis=1)
    assert_array_equal(reached, (way <= 1e-3) & (turn <= 1e-2))
    assert reached.mean() > 0.9
    assert ((qpos >= ROBOT.lower) & (qpos <= ROBOT.upper)).all()
