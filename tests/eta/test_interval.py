"""Intervals over seeds, against scipy's and against the formulas written out in loops."""

import math

import numpy as np
import pytest
import scipy.stats
from hypothesis import assume, example, given, strategies as st
from numpy.random import default_rng
from numpy.testing import assert_array_equal

from harness.eta import SHARE, UNBOUNDED
from harness.eta.interval import (
    Jackknife,
    are_bounds,
    difference_interval,
    jackknife,
    mean_interval,
    share_variance,
    spread_range,
)

NUMBERS = st.floats(-100.0, 100.0).map(lambda value: round(value, 6))
VALUES = st.lists(NUMBERS, min_size=3, max_size=12)
RATES = st.lists(st.integers(0, 50).map(lambda count: count / 50), min_size=2, max_size=12)


def mean_knife(*groups):
    """Of the mean of one group, or of the difference of two groups' means, in loops."""
    signs = (1.0,) if len(groups) == 1 else (-1.0, 1.0)
    value = sum(sign * sum(group) / len(group) for sign, group in zip(signs, groups, strict=True))
    left_out = [
        np.array([value + sign * ((sum(group) - out) / (len(group) - 1) - sum(group) / len(group)) for out in group])
        for sign, group in zip(signs, groups, strict=True)
    ]
    return Jackknife(value, tuple(left_out))


# Student's t


@given(VALUES, st.sampled_from([0.5, 0.9, 0.95]))
def test_interval_of_a_mean_is_scipys(values, confidence):
    """Student's interval for one sample."""
    assume(np.std(values) > 1e-3)
    expected = scipy.stats.ttest_1samp(values, 0.0).confidence_interval(confidence)
    found = mean_interval(values, np.var(values, ddof=1), confidence)
    assert found == pytest.approx((expected.low, expected.high), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("seeds", [2, 3, 10])
def test_spread_of_a_few_seeds_is_known_roughly(seeds):
    """Drawn 20,000 times, the true spread lies above the range in a tenth of all, and below it in another."""
    drawn = default_rng(seeds).normal(size=(20_000, seeds)).std(axis=1, ddof=1)
    smallest, largest = np.array([spread_range(spread, seeds) for spread in drawn]).T
    assert (largest < 1.0).mean() == pytest.approx(0.1, abs=0.01)
    assert (smallest > 1.0).mean() == pytest.approx(0.1, abs=0.01)


# Welch


def of_groups(baseline, proposed, confidence=0.95):
    """The interval of a measure that is no share."""
    return difference_interval(baseline, proposed, [np.var(it, ddof=1) for it in (baseline, proposed)], confidence)


@given(VALUES, VALUES, st.sampled_from([0.5, 0.9, 0.95]))
def test_interval_of_a_difference_is_scipys(one, other, confidence):
    """Welch's interval for two samples, of unequal length too."""
    assume(min(np.std(one), np.std(other)) > 1e-3)
    expected = scipy.stats.ttest_ind(other, one, equal_var=False).confidence_interval(confidence)
    assert of_groups(one, other, confidence) == pytest.approx((expected.low, expected.high), rel=1e-9, abs=1e-9)


def test_groups_without_a_spread_differ_by_a_point():
    """Unless a reserve stands for what was not seen."""
    assert of_groups([1.0] * 3, [0.5] * 5) == (-0.5, -0.5)


@pytest.mark.parametrize(
    ("bounds", "is_cut"), [(SHARE, True), (UNBOUNDED, False), ((0.0, 0.5), False), ((0.0, math.inf), False)]
)
def test_a_difference_is_cut_at_what_it_can_be(bounds, is_cut):
    """Bounds that a value leaves cut nothing."""
    found = difference_interval([1.0, 0.9, 1.0], [0.1, 0.2, 0.3, 0.2], (5.0, 5.0), bounds=bounds)
    assert (found == (-1.0, 1.0)) == is_cut


@pytest.mark.slow
@pytest.mark.parametrize("spreads", [(1.0, 1.0), (1.0, 3.0), (3.0, 1.0)])
@pytest.mark.parametrize("counts", [(4, 4), (5, 10), (10, 10), (20, 20)])
def test_an_interval_of_two_groups_covers_as_often_as_it_says(counts, spreads):
    """In .94 to .96 of 20,000 experiments; Monte Carlo error 0.0015."""
    rng = default_rng([*counts, int(spreads[0])])
    drawn = [spread * rng.normal(size=(20_000, count)) for spread, count in zip(spreads, counts, strict=True)]
    ends = np.array([of_groups(one, other) for one, other in zip(*drawn, strict=True)])
    covered = float(((ends[:, 0] <= 0.0) & (ends[:, 1] >= 0.0)).mean())
    print(f"{counts} trainings, spreads {spreads}: {covered:.3f}")  # noqa: T201
    assert 0.94 - 0.0045 <= covered <= 0.96 + 0.0045


# Shares of episodes


def test_share_variance_by_hand():
    """Rates 1, 0.9, 1, 0.7 of 10 episodes: s^2 is 0.02; 0.9 shrinks to 11 of 14, 0.012; the pseudo seed counts 1/4."""
    floor = 11 / 14 * 3 / 14 / 14
    assert floor < 0.02
    assert share_variance([1.0, 0.9, 1.0, 0.7], [0.9], 10) == pytest.approx((3 * 0.02 + 0.25**2) / 4)
    assert share_variance([0.9] * 4, [0.9], 10) == pytest.approx((3 * floor + 0.25**2) / 4)


@given(RATES, st.integers(1, 200))
@example([1.0] * 30, 1000)
def test_share_and_its_rest_have_one_spread(rates, episodes):
    """Failures are as uncertain as successes. An interval without a spread would say that no seed ever fails."""
    mean = float(np.mean(rates))
    rest = share_variance([1.0 - rate for rate in rates], [1.0 - mean], episodes)
    assert share_variance(rates, [mean], episodes) == pytest.approx(rest, rel=1e-9)
    assert rest > 0.0


def test_share_variance_of_values_far_apart_is_their_own():
    """The seed that was not seen makes no interval narrower, and of many seeds it loses its weight."""
    for rates, tolerance in (([0.0, 1.0] * 2, 1e-6), ([0.2, 0.8] * 5_000, 1e-3)):
        assert share_variance(rates, [0.5], 1_000_000) == pytest.approx(np.var(rates, ddof=1), rel=tolerance)


def test_difference_of_shares_has_both_groups_floors():
    """Each group's episodes are drawn by themselves."""
    one = share_variance([0.0] * 5, [1.0], 20)
    both = share_variance([0.0] * 5, [1.0, 1.0], 20)
    seed = 0.25**2 / 5
    assert both - seed == pytest.approx(2.0 * (one - seed))


# The jackknife


@given(VALUES)
def test_jackknife_of_a_mean_is_students_interval(values):
    """It is known to be: leaving one out shows the standard error of a mean exactly."""
    assume(np.std(values) > 1e-3)
    expected = mean_interval(values, np.var(values, ddof=1))
    assert mean_knife(values).interval() == pytest.approx(expected, rel=1e-6, abs=1e-6)


@given(VALUES, VALUES)
def test_jackknife_of_two_groups_is_welchs_interval(one, other):
    """Groups without pairs, each with its own spread and size."""
    assume(min(np.std(one), np.std(other)) > 1e-3)
    expected = scipy.stats.ttest_ind(other, one, equal_var=False).confidence_interval()
    assert mean_knife(one, other).interval() == pytest.approx((expected.low, expected.high), rel=1e-6, abs=1e-6)


def test_group_that_does_not_matter_costs_nothing():
    """A number of one group alone has that group's degrees of freedom; one that no seed changes is a point."""
    values, others = [1.0, 2.0, 4.0], [5.0] * 8
    alone, beside = mean_knife(values), mean_knife(others, values)
    assert np.diff(beside.interval()) == pytest.approx(np.diff(alone.interval()))
    assert Jackknife(0.75, (np.full(5, 0.75), np.full(3, 0.75))).interval() == (0.75, 0.75)


@pytest.mark.parametrize("unit", [1e-100, 1e100])
def test_unit_does_not_matter(unit):
    """Squares of variances would leave the range of numbers."""
    low, high = mean_knife([1.0, 2.0, 4.0]).interval()
    assert mean_knife([unit, 2.0 * unit, 4.0 * unit]).interval() == pytest.approx((unit * low, unit * high))


@pytest.mark.parametrize(
    ("value", "left_out"), [(1.0, 2.0), (math.nan, 2.0), (math.inf, 2.0), (1.0, math.nan), (1.0, -math.inf)]
)
def test_number_is_defined_if_it_is_without_any_seed(value, left_out):
    """One seed that alone keeps it from being none is too few."""
    assert Jackknife(value, (np.zeros(2), np.array([1.0, left_out]))).is_defined == ((value, left_out) == (1.0, 2.0))


def test_number_is_taken_of_what_is_left():
    """With all seeds, and without each, in both groups; logarithms of 0 and of less warn nobody."""
    whole = {"a": np.array([8.0]), "b": np.array([2.0])}
    left_out = [{"a": np.array([6.0, 9.0]), "b": np.array([2.0, 3.0])}]
    knife = jackknife(lambda sums: sums["a"] / sums["b"], whole, left_out)
    assert knife.value == 4.0
    assert_array_equal(knife.left_out, [[3.0, 3.0]])
    assert not jackknife(lambda sums: np.log(sums["a"]), whole, [{"a": np.array([0.0, -1.0])}]).is_defined


# What a value can be


@given(st.lists(st.floats(0.0, 1.0), min_size=3, max_size=8), st.floats(0.0, 1.0), st.floats(0.0, 4.0))
def test_a_cut_interval_holds_every_mean_that_it_held(values, truth, variance):
    """So that it covers as often: what is cut away could not be the truth."""
    whole, cut = (mean_interval(values, variance, bounds=bounds) for bounds in (UNBOUNDED, SHARE))
    assert (whole[0] <= truth <= whole[1]) == (cut[0] <= truth <= cut[1])
    assert 0.0 <= cut[0] <= cut[1] <= 1.0


@pytest.mark.parametrize(
    ("bounds", "cut"),
    [
        (UNBOUNDED, (-9.0, 11.0)),
        ((0.0, math.inf), (0.0, 11.0)),
        ((-math.inf, 2.0), (-9.0, 2.0)),
        ((0.0, 2.0), (0.0, 2.0)),
        (SHARE, (-9.0, 11.0)),
    ],
)
def test_an_interval_is_cut_at_the_ends_that_are_known(bounds, cut):
    """Either may be infinite; ends that a value leaves are wrong, and cut nothing."""
    values = [0.0, 1.0, 2.0]
    assert mean_interval(values, 3.0 * (10.0 / scipy.stats.t.ppf(0.975, 2)) ** 2, bounds=bounds) == pytest.approx(cut)


def test_rounding_does_not_leave_the_bounds():
    """A mean that is a hair beyond lies in its interval all the same."""
    low, high = mean_interval([1.0 - 1e-12] * 3, 1.0, bounds=(1.0, math.inf))
    assert low <= 1.0 - 1e-12 < high


@pytest.mark.parametrize(
    ("bounds", "fit"),
    [((0.0, 1.0), True), ([0, math.inf], True), ((1.0, 0.0), False), ((0.0,), False), ("01", False), ((0, "1"), False)],
)
def test_bounds_are_two_numbers_in_order(bounds, fit):
    """Strangers may give anything."""
    assert are_bounds(bounds) == fit
