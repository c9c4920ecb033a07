"""A measure under two rewards, means over several places."""

import numpy as np
import pytest
from numpy.random import default_rng

from harness.eta import change_of, swaps_of, together
from harness.eta.interval import Side, difference_bounds
from tests.eta.headlines import SUCCESS, TIME


def over(values, measure=SUCCESS, **kwargs):
    """Of values, (2, seeds, places)."""
    swaps = swaps_of(range(values.shape[1]))
    sides = np.moveaxis(values, 2, 0)
    return together([change_of(measure, *(dict(enumerate(it)) for it in side), swaps) for side in sides], **kwargs)


def test_means_are_over_seeds_and_then_over_places():
    """Every place counts alike."""
    values = np.zeros((2, 4, 2))
    values[1, :, 0] = 1.0
    assert (over(values).baseline, over(values).proposed) == (0.0, 0.5)


def test_the_interval_is_the_bound():
    """The one that the word rests on, at the confidence of all questions together."""
    values = default_rng(0).random(size=(2, 6, 3))
    found, wider = (over(values, confidence=confidence) for confidence in (0.95, 0.99))
    low, high = difference_bounds(*(Side(list(side.T), [(0.0, 1.0)] * 3) for side in values), 0.95)
    assert found.low <= low < high <= found.high
    assert wider.low < found.low < found.high < wider.high


def test_the_seed_that_was_not_seen_counts_less_in_more_places():
    """One of its places of four, one of sixteen: where no seed failed an interval of success is not empty."""
    few, many = (over(np.ones((2, 8, places))) for places in (4, 16))
    assert few.low < many.low < -0.01
    values = np.zeros((2, 3, 1))
    values[1] = 1.0
    assert over(values).high == 1.0, "a share differs by one at most"


def test_two_seeds_have_no_interval():
    """As in a single place."""
    found = over(np.zeros((2, 2, 4)))
    assert (found.low, found.high, found.likely) == (None, None, None)


def test_failed_trainings_are_counted_over_all_places():
    """Less than half of the episodes succeed."""
    values = np.ones((2, 3, 2))
    values[1, 2, 1] = 0.25
    assert (over(values).counts, over(values).failed) == ((6, 6), (0, 1))


def test_what_is_no_share_counts_relative_to_the_baseline():
    """A slow place says no more than a quick one, and half the time is 50 % less."""
    swaps = swaps_of(range(3))
    quick = change_of(TIME, {0: 1.0, 1: 1.1, 2: 0.9}, {0: 0.5, 1: 0.5, 2: 0.5}, swaps)
    slow = change_of(TIME, {0: 100.0, 1: 110.0, 2: 90.0}, {0: 50.0, 1: 50.0, 2: 50.0}, swaps)
    one, both = together([quick]), together([quick, slow])
    assert both.is_relative
    assert both.difference == pytest.approx(one.difference) == pytest.approx(-0.5)
    assert both.baseline == pytest.approx(1.0)
    assert not both.is_of_size


def test_a_time_cannot_fall_by_more_than_all_of_it():
    """Its interval relative to the baseline ends where nothing is left of it."""
    found = over(default_rng(1).uniform(0.1, 1.5, size=(2, 3, 2)), TIME)
    assert found.low == -1.0
    assert found.high > 1.0


def test_a_change_over_places_lies_between_those_of_the_places():
    """It has the sign of what is tested, where each counts relative to the mean size under both."""
    swaps = swaps_of(range(2))
    up = change_of(TIME, {0: 1.0, 1: 1.0}, {0: 1.5, 1: 1.5}, swaps)
    found = together([up, change_of(TIME, {0: 9.0, 1: 9.0}, {0: 3.0, 1: 3.0}, swaps)])
    tested = 0.5 / 1.25 - 6.0 / 6.0
    assert -6.0 / 9.0 < found.difference < 0.5
    assert np.sign(found.difference) == np.sign(tested)


@pytest.mark.parametrize("baseline", [{0: -1.0, 1: 1.5}, {0: 0.0, 1: 0.0}])
def test_values_of_either_sign_count_relative_to_their_size(baseline):
    """A return of about 0 is no unit; neither is a baseline of nothing."""
    found = together([change_of(TIME, baseline, {0: 2.0, 1: 2.0}, swaps_of(range(2)))])
    size = np.mean(np.abs([*baseline.values(), 2.0, 2.0]))
    assert found.is_of_size
    assert found.difference == pytest.approx((2.0 - np.mean(list(baseline.values()))) / size)


def test_the_bounds_allow_for_trainings_that_were_not_seen():
    """Perfect ones over two places say as much as twice as many in one."""
    one, two = over(np.ones((2, 12, 1))), over(np.ones((2, 6, 2)))
    assert two.likely[1] == pytest.approx(one.likely[1], abs=0.03)
    assert two.most == (1.0, 1.0)
