"""set-joints: the published baseline's jump."""

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from harness.task import build_motion
from tests.registered import UNITY_ARM


def test_the_arm_is_there_at_once(arm, setting_of, poses):
    """The one waypoint is the position of the action, and no speed is left."""
    motion, goal = build_motion("set-joints", setting_of(arm)), poses(arm, 30)
    move = motion.advance(np.tile(arm.home, (30, 1)), np.ones_like(goal), motion.stay(goal))
    assert_allclose(move.waypoints, [goal], atol=1e-12)
    assert_array_equal(move.qvel, 0.0)


def test_it_jumps(fd100, setting_of):
    """The arm is put there without dynamics; that of the other modes is driven."""
    modes = ("set-joints", "movej", "movej-absolute", "movel", "movea", "discrete:action=set-joints")
    assert [build_motion(mode, setting_of(fd100)).jumps for mode in modes] == [True, False, False, False, False, True]


def test_the_unity_arm_turns_as_published(setting_of):
    """Its action times (180, 90, 180, 90, 90) degrees is the pose."""
    action = np.array([[0.1, -0.2, 0.3, -0.4, 1.0]])
    move = build_motion("set-joints", setting_of(UNITY_ARM)).advance(UNITY_ARM.home[None], np.zeros((1, 5)), action)
    assert_allclose(np.degrees(move.waypoints[0]), action * [180.0, 90.0, 180.0, 90.0, 90.0])


def test_beyond_the_range_is_its_end(fd100, setting_of):
    """A huge action is the end of the range."""
    move = build_motion("set-joints", setting_of(fd100)).advance(
        fd100.home[None], np.zeros((1, 6)), np.full((1, 6), 1e300)
    )
    assert_array_equal(move.waypoints[0][0], fd100.upper)
