"""Arcs through three points."""

import numpy as np
import pytest
from hypothesis import assume, given, strategies as st
from numpy.linalg import norm
from numpy.testing import assert_allclose, assert_array_equal

from harness.motion.tip import arc_through

COORDINATE = st.floats(-1.0, 1.0).map(lambda number: round(number, 3))
POINT = st.tuples(COORDINATE, COORDINATE, COORDINATE).map(np.array)


def through(via, end):
    """The arc of one arm."""
    return arc_through(np.atleast_2d(via), np.atleast_2d(end))


def on(arc, distance):
    """The point after a distance."""
    return arc.point(np.full((1, 1), distance))[0]


def spans_a_plane(via, end):
    """Whether the three points are clearly no line."""
    sides = norm(via) * norm(end)
    return norm(np.cross(via, end)) > 0.01 * sides and norm(end - via) > 0.01


@given(POINT, POINT, st.floats(0.0, 1.0))
def test_an_arc_is_the_circle_through_its_points(via, end, share):
    """It begins at the origin, passes the via point and ends at the end, and a distance is the way that is gone."""
    assume(spans_a_plane(via, end))
    arc = through(via, end)
    length, center, radius = arc.length[0, 0], arc.radius[0] * arc.inward[0], arc.radius[0, 0]
    assert_array_equal(on(arc, 0.0), 0.0)
    assert_allclose(on(arc, length), end, atol=1e-6)
    assert norm(arc.point(np.linspace(0.0, arc.length[0], 4001)) - via, axis=1).min() < length / 4000
    place, step = share * length, 1e-4 * radius
    for point in (np.zeros(3), via, end, on(arc, place)):
        assert norm(point - center) == pytest.approx(radius, rel=1e-6)
    assert norm(on(arc, place + step) - on(arc, place)) == pytest.approx(step, rel=1e-4)


def test_half_a_circle():
    """From the origin over (1, 1) to (2, 0): the radius is 1, the length pi."""
    arc = through(np.array([1.0, 1.0, 0.0]), np.array([2.0, 0.0, 0.0]))
    assert (arc.radius[0, 0], arc.length[0, 0]) == pytest.approx((1.0, np.pi))
    assert_allclose(on(arc, np.pi / 2.0), [1.0, 1.0, 0.0], atol=1e-12)


def test_the_long_way_round():
    """Where the via point lies behind, it is three quarters of the circle."""
    arc = through(np.array([1.0, 1.0, 0.0]), np.array([1.0, -1.0, 0.0]))
    assert arc.length[0, 0] == pytest.approx(1.5 * np.pi)
    assert_allclose(arc.forward[0], [0.0, 1.0, 0.0], atol=1e-12)


@pytest.mark.parametrize("via", [(0.0, 0.0, 0.0), (0.5, 0.0, 0.0), (1.0, 0.0, 0.0), (-3.0, 0.0, 0.0)])
def test_a_line_where_there_is_no_circle(via):
    """Three points on one line, or two in one place, make the straight line to the end."""
    arc = through(np.array(via), np.array([1.0, 0.0, 0.0]))
    assert arc.length[0, 0] == 1.0
    assert_allclose(on(arc, 0.25), [0.25, 0.0, 0.0])


def test_nowhere_is_no_way():
    """An end at the start is no way, whatever the via point."""
    arc = through(np.array([0.3, 0.0, 0.0]), np.zeros(3))
    assert arc.length[0, 0] == 0.0
    assert_array_equal(on(arc, 0.0), 0.0)


def test_nearly_straight_is_nearly_the_line():
    """A circle of a radius of kilometres loses no precision."""
    arc = through(np.array([0.5, 1e-5, 0.0]), np.array([1.0, 0.0, 0.0]))
    assert_allclose(on(arc, 0.5), [0.5, 1e-5, 0.0], atol=1e-9)
