"""MoveJ to explicit positions: there, exactly, and no farther."""

import numpy as np
from numpy.testing import assert_allclose

from harness.task import build_motion


def test_lands_where_it_is_told(arm, setting_of, course_of, poses):
    """After long enough each joint is at the position of the action, and at rest."""
    motion = build_motion("movej-absolute", setting_of(arm))
    goal = poses(arm, 30, seed=1)
    course = course_of(motion, poses(arm, 30), [motion.stay(goal)] * 200)
    assert_allclose(course.qpos[-1], goal, rtol=0.0, atol=1e-12)
    assert_allclose(course.qvel[-1], 0.0, atol=1e-9)


def test_never_overshoots(arm, setting_of, course_of, poses):
    """On its way from rest no joint ever turns back."""
    motion = build_motion("movej-absolute", setting_of(arm))
    start, goal = poses(arm, 30), poses(arm, 30, seed=1)
    moves = np.diff(course_of(motion, start, [motion.stay(goal)] * 100).qpos, axis=0)
    assert (moves * np.sign(goal - start) >= -1e-12).all()


def test_goes_as_fast_as_it_may(fd100, setting_of, course_of):
    """On a long way every joint reaches its largest speed."""
    course = course_of(build_motion("movej-absolute", setting_of(fd100)), fd100.lower[None], [np.ones((1, 6))] * 30)
    assert_allclose(course.qvel[:, 0].max(axis=0), 0.8 * fd100.max_speed)
