"""MoveA: the end effector goes along the arc through a via point."""

import numpy as np
from hypothesis import given, settings, strategies as st
from numpy.linalg import norm
from numpy.testing import assert_allclose

from harness.motion.tip import arc_through
from harness.task import build_motion

COORDINATE = st.floats(-1.0, 1.0).map(lambda number: round(number, 2))
WAY = 0.05
"""Of a full action, [m]."""


def beside_the_arc(points, via, end):
    """How far each point is from the arc's circle, in its plane and out of it, [m]; start is the origin."""
    arc = arc_through(via[None], end[None])
    center, normal = arc.radius[0] * arc.inward[0], np.cross(arc.forward[0], arc.inward[0])
    out = points @ normal
    return np.hypot(norm(points - center - out[:, None] * normal, axis=1) - arc.radius[0, 0], out)


@settings(max_examples=30)
@given(action=st.tuples(*[COORDINATE] * 6).map(np.array))
def test_the_end_effector_stays_on_the_circle(fd100, setting_of, course_of, action):
    """From rest it is on the circle through start, via and end at each waypoint, however tight that is."""
    via, end = WAY * action[:3], WAY * action[3:]
    if norm(np.cross(via, end)) <= 1e-2 * norm(via) * norm(end) or not end.any():
        return
    course = course_of(build_motion("movea", setting_of(fd100)), fd100.home[None], [action[None]])
    tips = fd100.end_effector(course.qpos[:, 0])
    assert beside_the_arc(tips - tips[0], via, end).max() < 1e-4
    assert not course.held.any()


def test_it_goes_over_the_via_point(fd100, setting_of, course_of):
    """It sets out towards the via point's side, with the tangent of the circle."""
    action = np.array([[0.5, 0.5, 0.0, 1.0, 0.0, 0.0]])
    tips = fd100.end_effector(course_of(build_motion("movea", setting_of(fd100)), fd100.home[None], [action]).qpos)
    first = (tips[1] - tips[0])[0]
    assert_allclose(first / norm(first), [0.0, 1.0, 0.0], atol=0.15)


def test_three_points_on_a_line_are_movel(fd100, setting_of, course_of):
    """With the via point on the way, or nowhere, it is the straight movement to the end."""
    setting, end = setting_of(fd100), np.array([0.6, -0.2, 0.1])
    straight = course_of(build_motion("movel", setting), fd100.home[None], [end[None]] * 3)
    for via in (0.5 * end, 0.0 * end):
        arc = course_of(build_motion("movea", setting), fd100.home[None], [np.concatenate([via, end])[None]] * 3)
        assert_allclose(arc.qpos, straight.qpos, rtol=0.0, atol=1e-9)


def test_a_long_arc_is_gone_at_tip_speed(fd100, setting_of, course_of):
    """Of an arc that is longer than the way at tip_speed, that way is gone; the next action goes on from there."""
    motion, actions = build_motion("movea:tip_speed=0.1", setting_of(fd100)), []
    points = np.array([[np.sin(angle), 0.0, 1.0 - np.cos(angle)] for angle in (0.55, 1.1)])
    for k in range(5):
        (c, s) = np.cos(k), np.sin(k)  # a period is one radian of a circle of 1 cm
        actions.append((points @ [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]).reshape(1, 6))
    tips = fd100.end_effector(course_of(motion, fd100.home[None], actions).qpos[:, 0])
    assert_allclose(norm(np.diff(tips[-5:], axis=0), axis=1), 2.0 * 0.01 * np.sin(0.125), rtol=0.02)


def test_axes_are_those_of_the_frame(fd100, setting_of, course_of):
    """In a UCS whose axes are the world's, turned, the turned action does the same."""
    setting, action = setting_of(fd100), np.array([0.5, 0.3, 0.1, 1.0, 0.0, 0.2])
    turned = np.roll(action.reshape(2, 3), -1, axis=1).reshape(6)  # the user's x is the world's y
    world = course_of(build_motion("movea", setting), fd100.home[None], [action[None]])
    user = course_of(
        build_motion("movea:frame=ucs,ucs_x=0x1x0,ucs_xy=0x0x1", setting), fd100.home[None], [turned[None]]
    )
    assert_allclose(user.qpos, world.qpos, rtol=0.0, atol=1e-9)
