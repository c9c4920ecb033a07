"""MoveJ: an action is a share of the joints' speed."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.motion.motion import MoveJ


@pytest.fixture(scope="module")
def motion(fd100):
    """The FD100's."""
    return MoveJ.within_limits(fd100, speed=0.8, acceleration=0.6, period=0.1)


@given(seed=st.integers(0, 2**32 - 1))
def test_batch_is_its_envs_one_by_one(motion, seed):
    """Each arm of a batch gets, bit for bit, what it gets alone, also where only its neighbours have to brake."""
    rng, limits = default_rng(seed), motion.limits
    share = rng.choice([0.0, 0.001, 0.5, 0.999, 1.0], (4, 1)) * np.ones(limits.lower.shape)
    qpos = limits.lower + share * (limits.upper - limits.lower)
    qvel = rng.uniform(-1.0, 1.0, qpos.shape) * limits.max_change * (np.abs(share - 0.5) < 0.4)
    action = rng.uniform(-1.0, 1.0, qpos.shape)
    move = motion.advance(qpos, qvel, action)
    for env in range(len(qpos)):
        alone = motion.advance(*(array[env : env + 1] for array in (qpos, qvel, action)))
        assert_array_equal(alone.waypoints[0][0], move.waypoints[0][env])
        assert_array_equal(alone.qvel[0], move.qvel[env])


def test_arguments_are_left_alone(motion, fd100):
    """Positions, speeds and actions of the caller are not changed."""
    given_arrays = np.array(fd100.home)[None], np.zeros((1, 6)), np.full((1, 6), 3.0)
    before = [array.copy() for array in given_arrays]
    motion.advance(*given_arrays)
    for array, old in zip(given_arrays, before, strict=True):
        assert_array_equal(array, old)


def test_action_beyond_the_box_is_clipped(motion, fd100, subtests):
    """However large an action, it is one of 1."""
    for beyond in [7.0, 1e300, np.inf]:
        for sign in [1.0, -1.0]:
            with subtests.test(beyond=beyond, sign=sign):
                moves = [
                    motion.advance(fd100.home[None], np.zeros((1, 6)), np.full((1, 6), sign * a)) for a in (beyond, 1.0)
                ]
                assert_array_equal(moves[0].qvel, moves[1].qvel)


def test_robot_takes_its_shares_of_speed_and_acceleration(motion, fd100, course_of):
    """A full action gains 60 % of the maximum acceleration per period, up to 80 % of the maximum speed."""
    speeds = course_of(motion, fd100.home[None], [np.ones((1, 6))] * 4).qvel[:, 0]
    assert_allclose(speeds[0], np.minimum(0.6 * fd100.max_acceleration * 0.1, motion.limits.max_speed))
    assert_allclose(speeds[-1], 0.8 * fd100.max_speed)


@pytest.mark.parametrize("action", [0.25, -0.5])
def test_action_is_a_fraction_of_the_maximum_speed(motion, fd100, course_of, action):
    """In the end a joint has the speed that is asked for."""
    speeds = course_of(motion, fd100.home[None], [np.full((1, 6), action)] * 3).qvel
    assert_allclose(speeds[-1, 0], action * motion.limits.max_speed)


def test_the_check_on_limits_sees_a_fault(fd100, setting_of, course_of, require_limits, poses):
    """A motion that brakes less than it has to fails the check above."""
    motion = MoveJ(setting_of(fd100).limits())
    stricter = replace(motion.limits, max_change=0.5 * motion.limits.max_change)
    course = course_of(motion, poses(fd100, 5), [np.ones((5, 6))] * 20)
    with pytest.raises(AssertionError):
        require_limits(course, stricter)
