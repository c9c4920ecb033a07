"""Measures over seeds beyond the mean, against slow computations of their own."""

import numpy as np
import pytest
import scipy.stats
from hypothesis import given, strategies as st

from harness.eta.behaviour_change import performance_profile
from tests.eta.headlines import TIME, change
from tests.eta.test_amounts import HEIGHT

VALUES = st.lists(st.integers(-5, 5).map(float), min_size=1, max_size=8)


def middle(values):
    """The interquartile mean of the baseline."""
    return change(values, [], TIME).middles[0]


def test_of_three_no_quarter_can_be_left_out():
    """So there is no interquartile mean."""
    assert [middle([1.0] * count) for count in (0, 1, 3)] == [None] * 3


@given(VALUES, VALUES)
def test_probability_of_improvement_counts_pairs(one, other):
    """Any run against any, ties half; the Mann-Whitney U over the number of pairs. Of times less is better."""
    pairs = [1.0 if k > b else 0.5 if k == b else 0.0 for b in one for k in other]
    found = change(one, other, HEIGHT).improvement
    assert found == pytest.approx(sum(pairs) / len(pairs))
    assert found == pytest.approx(scipy.stats.mannwhitneyu(other, one).statistic / len(pairs))
    assert found + change(one, other, TIME).improvement == pytest.approx(1.0)


@pytest.mark.parametrize("sides", [([], [1.0]), ([1.0], [])])
def test_improvement_needs_runs_on_both_sides(sides):
    """Otherwise there is no pair."""
    assert change(*sides, HEIGHT).improvement is None


@given(VALUES)
def test_profile_falls_from_all_to_none(values):
    """All runs reach the lowest value, none more than the highest; it never rises."""
    at = np.array([min(values), *sorted(set(values)), max(values) + 1.0])
    profile = performance_profile(values, at)
    assert profile[[0, -1]].tolist() == [1.0, 0.0]
    assert (np.diff(profile) <= 0.0).all()


@given(st.lists(st.floats(-1e6, 1e6), min_size=4, max_size=60))
def test_middle_half_is_scipys(values):
    """To the last bit: published numbers rest on it."""
    assert middle(values) == float(scipy.stats.trim_mean(values, 0.25))
