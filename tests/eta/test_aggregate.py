"""Measures over seeds beyond the mean, against slow computations of their own."""

import math

import numpy as np
import pytest
import scipy.stats
from hypothesis import given, strategies as st

from harness.eta.behaviour_change import interquartile_mean, performance_profile, probability_of_improvement

VALUES = st.lists(st.integers(-5, 5).map(float), min_size=1, max_size=12)


def test_interquartile_mean_leaves_out_a_quarter_at_each_end():
    """Two of eight, the outlier among them."""
    assert interquartile_mean([1000.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, -1000.0]) == pytest.approx(3.5)


@pytest.mark.parametrize("count", [0, 1, 3])
def test_interquartile_mean_needs_four(count):
    """Of three no quarter can be left out."""
    assert interquartile_mean([1.0] * count) is None


@given(VALUES, VALUES)
def test_probability_of_improvement_counts_pairs(one, other):
    """Any run against any, ties half; the Mann-Whitney U over the number of pairs."""
    pairs = [1.0 if k > b else 0.5 if k == b else 0.0 for b in one for k in other]
    found = probability_of_improvement(one, other, "higher")
    assert found == pytest.approx(sum(pairs) / len(pairs))
    assert found == pytest.approx(scipy.stats.mannwhitneyu(other, one).statistic / len(pairs))


@given(VALUES, VALUES)
def test_lower_is_the_opposite_of_higher(one, other):
    """What is better for one reading is worse for the other."""
    both = [probability_of_improvement(one, other, better) for better in ("higher", "lower")]
    assert math.fsum(value for value in both if value is not None) == pytest.approx(1.0)


def test_improvement_needs_runs_on_both_sides():
    """Otherwise there is no pair."""
    assert probability_of_improvement([], [1.0], "higher") is None
    assert probability_of_improvement([1.0], [], "higher") is None


@given(VALUES)
def test_profile_falls_from_all_to_none(values):
    """All runs reach the lowest value, none more than the highest; it never rises."""
    at = np.array([min(values), *sorted(set(values)), max(values) + 1.0])
    profile = performance_profile(values, at)
    assert profile[0] == 1.0
    assert profile[-1] == 0.0
    assert (np.diff(profile) <= 0.0).all()


@given(st.lists(st.floats(-1e6, 1e6), min_size=4, max_size=60))
def test_middle_half_is_scipys(values):
    """To the last bit: published numbers rest on it."""
    assert interquartile_mean(values) == float(scipy.stats.trim_mean(values, 0.25))
