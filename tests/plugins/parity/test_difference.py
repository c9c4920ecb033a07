"""Differences by class: each fault is told by the figure that is there for it."""

import numpy as np
import pytest
from numpy.random import default_rng

from harness_plugins.parity.difference import after_contact, difference_between, response_of
from harness_plugins.parity.motions import smooth_motions
from harness_plugins.parity.track import Track

PERIOD = 0.1


@pytest.fixture(scope="module")
def told(robot):
    """Two smooth motions."""
    return smooth_motions(robot, 0, 2, 80, PERIOD).motions


@pytest.fixture(scope="module")
def track(robot):
    """A track that is at these joint positions."""

    def call(qpos, contact=None):
        return Track(qpos, robot.end_effector(qpos), np.zeros(qpos.shape[:2], bool) if contact is None else contact)

    return call


def late(told, delay):
    """Where the joints were so long before, at constant speed within a period."""
    speed = np.diff(told, axis=0, prepend=told[:1]) / PERIOD
    return told - delay * speed


def test_who_does_what_is_told_has_no_error(robot, told, track):
    """Nor any delay, and reaches the speed that it is told."""
    found = response_of(track(told), told, robot, PERIOD)
    assert (found.tracking_error_m, found.falls_short, found.lag_s) == (0.0, 0.0, 0.0)
    assert found.speed_reached == found.speed_told == pytest.approx(0.8, abs=0.05)


def test_a_delay_is_told_in_seconds(robot, told, track):
    """And explains the difference; the other way round it is negative."""
    on_time, behind = track(told), track(late(told, 0.02))
    assert response_of(behind, told, robot, PERIOD).lag_s == pytest.approx(0.02)
    found = difference_between(on_time, behind, told, robot, PERIOD)
    assert (found.lag_s, found.explained_by_lag) == (pytest.approx(0.02), pytest.approx(1.0))
    assert difference_between(behind, on_time, told, robot, PERIOD).lag_s == pytest.approx(-0.02)


def test_what_is_no_delay_is_not_explained_by_one(robot, told, track):
    """Noise."""
    noise = default_rng(0).normal(0.0, 0.01, told.shape)
    assert difference_between(track(told), track(told + noise), told, robot, PERIOD).explained_by_lag < 0.05


def test_a_drive_that_is_too_weak_falls_short(robot, told, track):
    """It has at most half of the speed that joints may have."""
    speed = np.diff(told, axis=0) / PERIOD
    slow = np.minimum(np.maximum(speed, -0.5 * robot.max_speed), 0.5 * robot.max_speed)
    weak = told[0] + np.concatenate([np.zeros_like(told[:1]), np.cumsum(slow * PERIOD, axis=0)])
    found = response_of(track(weak), told, robot, PERIOD)
    assert found.falls_short == pytest.approx((np.abs(speed) / robot.max_speed > 0.6).mean())
    assert found.falls_short > 0.0
    assert found.speed_reached == pytest.approx(0.5)


def test_the_worst_place_is_named(robot, told, track):
    """Its time, its motion, its joint, and what that joint is told."""
    other = told.copy()
    other[30, 1, 2] += 0.1
    found = difference_between(track(told), track(other), told, robot, PERIOD)
    assert found.worst[:3] == (pytest.approx(3.0), 1, robot.joint_names[2])
    assert found.worst.speed_told == pytest.approx(abs(told[30, 1, 2] - told[29, 1, 2]) / PERIOD / robot.max_speed[2])
    assert found.max_joint_error_rad == pytest.approx(0.1)
    assert 0.0 < found.mean_tip_error_m == pytest.approx(found.max_tip_error_m / 160)


def test_differences_where_joints_turn_are_told(robot, told, track):
    """Many times larger there than elsewhere."""
    speed = np.diff(told, axis=0, prepend=told[:1]) / PERIOD
    share = (np.abs(np.diff(speed, axis=0, prepend=speed[:1])) / PERIOD / robot.max_acceleration).max(axis=-1)
    offset = np.where(share >= 0.5 * share.max(), 0.01, 0.001)[..., None]
    assert 5.0 < difference_between(track(told), track(told + offset), told, robot, PERIOD).turning < 20.0


def test_after_contact_counts_from_the_first_one_that_either_sees(robot, told, track):
    """Times are since then; a dive that touches nothing counts nothing."""
    sees, blind = np.zeros(told.shape[:2], bool), np.zeros(told.shape[:2], bool)
    sees[50:, 0] = True
    one, other = track(told, blind), track(told + 0.01 * (np.arange(81) >= 60)[:, None, None], sees)
    counted = after_contact(one, other)
    assert counted.sum(axis=0).tolist() == [31, 0]
    found = difference_between(one, other, told, robot, PERIOD, counted)
    assert found.worst.episode == 0
    assert found.worst.time_s >= 1.0 - 1e-9
    assert difference_between(one, one, told, robot, PERIOD, after_contact(one, one)) is None
