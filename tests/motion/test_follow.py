"""Following a way: what is held, what is not, and what happens where the arm is awkward."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.linalg import norm
from numpy.random import default_rng
from numpy.testing import assert_allclose

from harness.motion.tip import Follower
from harness.task import build_motion
from tests.registered import UNITY_ARM


@pytest.fixture(scope="module")
def follower(fd100, setting_of):
    """The FD100's, of quarters of a control period."""
    return Follower(fd100, setting_of(fd100).limits(4), 0.5)


def test_a_point_out_of_reach_is_held_at_once(follower, fd100):
    """Stretched out, the arm is told to go on: it is held and does not move."""
    straight = _most_stretched(fd100, np.radians([[0.0, 90.0, -78.0, 0.0, 0.0, 0.0]]))
    outward = fd100.end_effector(straight) * [1.0, 1.0, 0.0]
    move = follower.pass_along(straight, np.zeros((1, 6)), lambda gone: gone * 0.05 * outward, 4)
    assert move.held.all()
    assert_allclose(move.waypoints[-1], straight, atol=0.02)


AXIS = st.sampled_from([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.6, -0.8)])
LINK = st.tuples(*[st.sampled_from([0.0, 0.05, 0.3, -0.4])] * 3)
JOINTS = st.lists(st.tuples(st.sampled_from(["revolute", "prismatic"]), AXIS, LINK), min_size=3, max_size=7)


@settings(max_examples=40)
@given(joints=JOINTS, mode=st.sampled_from(["movel", "movel:frame=tcs,parts=1", "movea"]), seed=st.integers(0, 999))
def test_any_chain_stays_within_its_limits(arm_of, setting_of, course_of, require_limits, poses, joints, mode, seed):
    """Turns and slides in any order, also where the end effector can hardly move: finite, in range, no jerk."""
    robot = arm_of("any", joints)
    motion, rng = build_motion(mode, setting_of(robot)), default_rng(seed)
    start = np.concatenate([poses(robot, 6, seed=seed), robot.lower[None], robot.upper[None], 0.0 * robot.home[None]])
    actions = [action for action in rng.uniform(-2.0, 2.0, (4, 9, motion.action_size)) for _ in range(4)]
    require_limits(course_of(motion, start, actions), motion.follower.limits)


def test_a_joint_at_its_end_leaves_the_way_to_the_others(fd100, setting_of, course_of):
    """With the wrist at an end of its range the other joints do the movement: nothing is held."""
    start = fd100.home.copy()
    start[4] = fd100.upper[4]
    motion = build_motion("movel", setting_of(fd100))
    for direction in np.concatenate([np.eye(3), -np.eye(3)]):
        course = course_of(motion, start[None], [0.2 * direction[None]] * 4)
        way = np.diff(fd100.end_effector(course.qpos[[0, -1], 0]), axis=0)[0]
        assert not course.held.any()
        assert_allclose(way / norm(way), direction, atol=1e-2)


def test_a_range_that_blocks_is_held(setting_of, course_of):
    """Driven down until it cannot go on, the unity-arm is held and stands."""
    motion = build_motion("movel", setting_of(UNITY_ARM))
    course = course_of(motion, UNITY_ARM.home[None], [np.array([[0.0, 0.0, -1.0]])] * 150)
    assert course.held[-20:].all()
    assert_allclose(course.qpos[-1], course.qpos[-80], atol=1e-9)


def test_leaves_the_edge_again(fd100, setting_of, course_of, directions):
    """From where it was held at the edge of its reach the arm comes back when it is told to."""
    motion, outward = build_motion("movel", setting_of(fd100)), directions(20)
    out = course_of(motion, np.tile(fd100.home, (20, 1)), [outward] * 60)
    back = course_of(motion, out.qpos[-1], [-outward] * 60)
    tips = fd100.end_effector(back.qpos)
    gone = np.vecdot(tips[-1] - tips[0], -outward)
    assert out.held[-1].any()
    assert np.median(gone) > 0.3
    assert not back.held[:10].all(axis=1).any()


def test_turning_speed_takes_half_the_acceleration(follower, fd100):
    """At that speed on that circle some joint needs half of what it has, and none needs more."""
    radius, home = np.array([[0.02]]), fd100.home[None]
    u, v = np.eye(3)[[0]], np.eye(3)[[1]]
    speed = follower.turning_speed(home, u, v, radius)
    pinv = np.linalg.pinv(fd100.jacobian(fd100.home))
    angles = np.linspace(0.0, 2.0 * np.pi, 721)
    inward = speed[0, 0] ** 2 / radius[0, 0] * (np.cos(angles)[:, None] * u + np.sin(angles)[:, None] * v)
    share = np.abs(inward @ pinv.T) / (0.6 * fd100.max_acceleration)
    assert share.max() == pytest.approx(0.5, rel=0.01)


def test_a_way_of_no_length_brakes(follower, fd100):
    """Nothing asked for is nothing held: the joints slow down in their ratio."""
    qvel = np.array([[0.5, -0.4, 0.3, 0.0, 0.1, 0.0]])
    move = follower.pass_along(fd100.home[None], qvel, lambda gone: np.zeros((1, 3)), 1)
    assert_allclose(move.qvel / norm(move.qvel), qvel / norm(qvel))
    assert np.abs(move.qvel).max() < 0.5
    assert not move.held.any()


def _most_stretched(robot, qpos):
    """Joints 3 and 5 at their farthest out, from a pose with the arm level."""
    third, fifth = np.meshgrid(np.linspace(-1.39, 1.39, 281), np.linspace(-0.5, 0.5, 101), indexing="ij")
    poses = np.tile(qpos, (third.size, 1))
    poses[:, 2], poses[:, 4] = third.ravel(), fifth.ravel()
    shoulder = np.array([0.18, 0.0, 0.43])
    return poses[[norm(robot.end_effector(poses) - shoulder, axis=1).argmax()]]
