"""Motions by class: each within the limits of its class, clear of the ground, the same for the same seed."""

from dataclasses import replace

import numpy as np
import pytest

from harness_plugins.parity.classes import class_motions, draw_fast, draw_singular, shares_told, told_by
from harness_plugins.parity.motions import GroundClearance, point_heights

CLEARANCE = 0.1


@pytest.fixture(scope="module")
def motions(each_robot):
    """Two of each class, 60 control periods of 0.1 s."""
    return {name: drawn.motions for name, drawn in class_motions(each_robot, 0, 2, 60, 0.1).items()}


def test_there_are_three_classes_beside_smooth_ones_and_dives(motions, each_robot):
    """All of one shape."""
    assert {name: motion.shape for name, motion in motions.items()} == dict.fromkeys(
        ("slow", "fast", "singular"), (61, 2, each_robot.dof)
    )


def test_limits_are_kept(motions, each_robot):
    """Ranges, speeds and accelerations, from rest on, in every class; and tip and joints stay above the ground."""
    for name, motion in motions.items():
        told = told_by(each_robot, motion, 0.1)
        assert told.speed <= 1.0 + 1e-9, name
        assert told.acceleration <= 1.0 + 1e-9, name
        assert (each_robot.lower <= motion).all(), name
        assert (motion <= each_robot.upper).all(), name
        heights = point_heights(each_robot, motion.reshape(-1, each_robot.dof))
        assert heights.min() >= CLEARANCE * each_robot.reach - 1e-12, name


def test_slow_is_slow_and_fast_is_at_the_limits(motions, each_robot):
    """Fast joints have their largest speed most of the time, and turn at their largest acceleration."""
    slow, fast = (told_by(each_robot, motions[name], 0.1) for name in ("slow", "fast"))
    assert slow.speed <= 0.2 + 1e-9
    assert slow.acceleration <= 0.1 + 1e-9
    assert (fast.speed, fast.acceleration) == (pytest.approx(1.0), pytest.approx(1.0))
    speed, _ = shares_told(each_robot, motions["fast"], 0.1)
    assert np.mean(speed[1:] > 0.99) > 0.2


def test_singular_motions_stay_near_a_singular_pose(motions, each_robot):
    """Its smallest singular value is far below that of home."""
    motion = motions["singular"]
    assert np.abs(motion - motion[0]).max() <= 0.15 + 1e-9
    home = np.linalg.svd(each_robot.jacobian(each_robot.home), compute_uv=False)[-1]
    values = np.linalg.svd(each_robot.jacobian(motion[0]), compute_uv=False)[:, -1]
    assert (values < 0.02 * each_robot.reach).all()
    assert (values < home).all()


def test_a_seed_gives_the_same_motions(robot):
    """Motion n is the same in every batch; another seed gives others."""
    few, many, other = (class_motions(robot, seed, count, 12, 0.1) for seed, count in ((5, 1), (5, 2), (6, 1)))
    for name in few:
        np.testing.assert_array_equal(few[name].motions, many[name].motions[:, :1])
        assert not np.isclose(few[name].motions[-1], other[name].motions[-1]).all()


def test_a_fast_motion_that_cannot_go_on_stops(robot):
    """An arm whose every way leads to the ground brakes, and stays where it is."""
    low = point_heights(robot, robot.home[None])[1:].min() / CLEARANCE  # all but the second joint, which stands still
    larger = _with_reach(robot, 1.5 * low)
    motion = draw_fast(larger, np.random.default_rng(0), 30, 0.1, GroundClearance(larger))
    np.testing.assert_array_equal(motion[1:], np.tile(motion[0], (30, 1)))


def test_near_the_ground_there_is_no_singular_motion(robot):
    """None, not one that meets it."""
    larger = _with_reach(robot, 100.0)
    assert draw_singular(larger, np.random.default_rng(0), 5, 0.1, GroundClearance(larger)) is None


def _with_reach(robot, reach):
    """A robot that takes itself for larger, so that it keeps farther from the ground."""
    larger = replace(robot)
    larger.__dict__["reach"] = reach
    return larger
