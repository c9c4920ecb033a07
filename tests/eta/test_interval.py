"""Intervals over seeds, against scipy's and against the formulas written out in loops."""

import math

import numpy as np
import pytest
import scipy.stats
from hypothesis import assume, given, strategies as st
from numpy.random import default_rng
from numpy.testing import assert_array_equal

from harness.eta import SHARE
from harness.eta.interval import (
    Jackknife,
    are_bounds,
    cut_to,
    jackknife,
    spread_range,
)

NUMBERS = st.floats(-100.0, 100.0).map(lambda value: round(value, 6))
VALUES = st.lists(NUMBERS, min_size=3, max_size=12)


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


@pytest.mark.parametrize("seeds", [2, 3, 10])
def test_spread_of_a_few_seeds_is_known_roughly(seeds):
    """Drawn 20,000 times, the true spread lies above the range in a tenth of all, and below it in another."""
    drawn = default_rng(seeds).normal(size=(20_000, seeds)).std(axis=1, ddof=1)
    smallest, largest = np.array([spread_range(spread, seeds) for spread in drawn]).T
    assert (largest < 1.0).mean() == pytest.approx(0.1, abs=0.01)
    assert (smallest > 1.0).mean() == pytest.approx(0.1, abs=0.01)


# The jackknife


@given(VALUES)
def test_jackknife_of_a_mean_is_students_interval(values):
    """It is known to be: leaving one out shows the standard error of a mean exactly."""
    assume(np.std(values) > 1e-3)
    expected = scipy.stats.ttest_1samp(values, 0.0).confidence_interval()
    assert mean_knife(values).interval() == pytest.approx((expected.low, expected.high), rel=1e-6, abs=1e-6)


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


@given(st.floats(0.0, 1.0), st.floats(-2.0, 1.0), st.floats(0.0, 3.0))
def test_a_cut_interval_holds_what_it_held(truth, low, width):
    """So that it covers as often: what is cut away could not be the truth."""
    whole = (low, low + width)
    cut = cut_to(whole, SHARE)
    assert (whole[0] <= truth <= whole[1]) <= (cut[0] <= truth <= cut[1])
    assert cut[0] <= cut[1]


@pytest.mark.parametrize(
    ("bounds", "fit"),
    [((0.0, 1.0), True), ([0, math.inf], True), ((1.0, 0.0), False), ((0.0,), False), ("01", False), ((0, "1"), False)],
)
def test_bounds_are_two_numbers_in_order(bounds, fit):
    """Strangers may give anything."""
    assert are_bounds(bounds) == fit
