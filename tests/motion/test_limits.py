"""Joint limits: whatever speed is wanted, the joints stay within their limits, and can stop."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from harness.motion.motion import JointLimits, stopping_speed

WANTED = st.lists(st.sampled_from([-1.0, -0.4, 0.0, 0.3, 1.0]), min_size=1, max_size=40)


@st.composite
def some_limits(draw):
    """Of one joint with any range, also where it needs many periods to brake."""
    lower = draw(st.floats(-3.0, 3.0))
    width = draw(st.floats(0.01, 5.0))
    max_speed = draw(st.floats(0.5, 10.0))
    max_change = max_speed * draw(st.floats(0.05, 2.0))
    period = draw(st.floats(0.05, 0.2))
    return JointLimits(*(np.array([number]) for number in (lower, lower + width, max_speed, max_change)), period)


def follow(limits, start, wanted):
    """Positions and speeds, (periods + 1, dof), of shares of the maximum speed, from rest at a place in the range."""
    qpos = limits.position(np.full((1, len(limits.lower)), 2.0 * start - 1.0))
    path = [(qpos, np.zeros_like(qpos))]
    for share in wanted:
        path.append(limits.advance(*path[-1], share * limits.max_speed[None]))
    positions, speeds = zip(*path, strict=True)
    return np.concatenate(positions), np.concatenate(speeds)


@given(some_limits(), st.floats(0.0, 1.0), WANTED)
def test_every_step_keeps_the_limits(limits, start, wanted):
    """Of speed, its change, and the range; at the speed that is told, which lies between the bounds told for it.

    So the range's end never cuts a motion short.
    """
    positions, speeds = follow(limits, start, wanted)
    assert (np.abs(speeds) <= limits.max_speed * (1.0 + 1e-9)).all()
    assert (np.abs(np.diff(speeds, axis=0)) <= limits.max_change * (1.0 + 1e-9)).all()
    assert (positions >= limits.lower).all()
    assert (positions <= limits.upper).all()
    assert_allclose(np.diff(positions, axis=0), speeds[1:] * limits.period, rtol=0.0, atol=1e-9)
    low, high = limits.bounds(positions[:-1], speeds[:-1])
    assert (low <= speeds[1:] + 1e-9).all()
    assert (high >= speeds[1:] - 1e-9).all()


def test_rounding_does_not_take_a_joint_beyond_its_range():
    """A joint that can brake at once goes back to the very end of its range, and no further."""
    limits = JointLimits(*(np.array([number]) for number in (1e-20, 0.5, 2.0, 4.0)), 0.125)
    positions, _ = follow(limits, 0.0, [0.0, -0.4, -0.4, 1.0, -1.0, -1.0, 0.3])
    assert (positions >= limits.lower).all()


@given(some_limits(), st.floats(0.0, 1.0), WANTED)
def test_joint_can_always_stop(limits, start, wanted):
    """Told to stop, a joint stands still after as many periods as its speed takes, wherever it is."""
    periods = int(np.ceil(limits.max_speed[0] / limits.max_change[0])) + 1
    _, speeds = follow(limits, start, wanted + [0.0] * periods)
    assert abs(speeds[-1, 0]) < 1e-9


@given(some_limits(), st.sampled_from([-1.0, 1.0]))
def test_both_ends_can_be_reached(limits, direction):
    """Driven on in one direction, a joint comes to rest at the end of its range: the brake is not too careful."""
    periods = int(np.ceil((limits.upper - limits.lower)[0] / (limits.max_speed[0] * limits.period)))
    braking = int(np.ceil(limits.max_speed[0] / limits.max_change[0]))
    positions, _ = follow(limits, 0.5, [direction] * (4 * (periods + braking) + 60))
    end = limits.upper if direction > 0.0 else limits.lower
    assert_allclose(positions[-1], end, atol=1e-6)


@given(some_limits(), st.floats(0.0, 1.0), WANTED)
def test_the_short_way_is_the_long_way(limits, start, wanted):
    """A step that is seen to need no braking is the one that the search for braking would have given."""
    careful = JointLimits(limits.lower, limits.upper, limits.max_speed, limits.max_change, limits.period)
    object.__setattr__(careful, "_free", np.full((1, 1), -1.0))
    for quick, long in zip(follow(limits, start, wanted), follow(careful, start, wanted), strict=True):
        assert_allclose(quick, long, rtol=0.0, atol=1e-12)


@given(st.floats(0.0, 10.0), st.floats(0.1, 5.0), st.floats(0.01, 1.0))
def test_stopping_speed_stops_at_the_end_of_the_room(room, change, period):
    """Braking by the largest change every period, a speed covers exactly the room that it is told for."""
    speed = float(stopping_speed(np.array(room), np.array(change), period))
    covered = sum(max(0.0, speed - k * change) * period for k in range(int(speed / change) + 2))
    assert covered == pytest.approx(room, rel=1e-6, abs=1e-9)


def test_position_is_the_inverse_of_normalised():
    """A place in the ranges comes back."""
    limits = JointLimits(np.array([-1.0, 0.0]), np.array([3.0, 0.5]), np.ones(2), np.ones(2), 0.1)
    places = np.array([[-1.0, 0.1], [2.9, 0.5]])
    assert_allclose(limits.position(limits.normalised(places)), places)


def test_position_beyond_the_ends_is_the_end():
    """However large a number, the place is in the range."""
    limits = JointLimits(np.array([-1.0]), np.array([3.0]), np.ones(1), np.ones(1), 0.1)
    assert_array_equal(limits.position(np.array([[1e300], [-np.inf]])), [[3.0], [-1.0]])
