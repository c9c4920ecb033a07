"""The mean over seeds, and how far it can be trusted."""

import numpy as np
import pytest
import scipy.stats
from hypothesis import assume, given, strategies as st

from harness.eta import SHARE, Estimate, mean_over_seeds

NUMBERS = st.lists(st.floats(-1e3, 1e3).map(lambda value: round(value, 6)), min_size=3, max_size=12)


@given(NUMBERS)
def test_interval_is_students(values):
    """Scipy's for one sample."""
    assume(np.std(values) > 1e-3)
    found, expected = mean_over_seeds(values), scipy.stats.ttest_1samp(values, 0.0).confidence_interval()
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high), rel=1e-6, abs=1e-6)
    assert found.value == pytest.approx(sum(values) / len(values), abs=1e-9)
    assert found.seeds == len(values)


def test_values_that_are_all_the_same_have_no_spread():
    """A measure that no seed changes is known."""
    found = mean_over_seeds([0.25] * 5)
    assert (found.low, found.high) == (0.25, 0.25)


def test_shares_that_are_all_the_same_have_one():
    """Five seeds without a failure do not show that there is none: a sixth may fail."""
    found = mean_over_seeds([1.0] * 5, bounds=SHARE)
    theirs = scipy.stats.ttest_1samp([1.0] * 5 + [0.0], 0.0).confidence_interval()
    assert (found.low, found.high) == (pytest.approx(theirs.low), 1.0)


@pytest.mark.parametrize(("values", "told"), [([0.5], "one seed"), ([0.25, 0.75], "2 seeds")])
def test_fewer_than_three_seeds_have_no_interval(values, told):
    """And say so, as plain data too."""
    found, note = mean_over_seeds(values), f"{told}: no interval below 3 seeds"
    assert found == Estimate(0.5, None, None, len(values), (note,))
    assert found.to_json() == {"value": 0.5, "low": None, "high": None, "seeds": len(values), "note": note}


def test_no_value_has_the_reason():
    """n/a, never a number that is none."""
    nothing = Estimate(None, notes=("1 of 1 failed",))
    assert mean_over_seeds([], "1 of 1 failed") == nothing


def test_seeds_that_are_missing_are_told_last():
    """Beside why there is no interval, or alone."""
    assert mean_over_seeds([0.1, 0.2], "1 of 3 failed").note == "2 seeds: no interval below 3 seeds; 1 of 3 failed"
    assert mean_over_seeds([0.1] * 5, "1 of 6 failed").note == "1 of 6 failed"
    assert mean_over_seeds([0.1] * 5).note == ""


@pytest.mark.parametrize("values", [[1.0, 1.0, 1.0, 0.6], [0.0, 0.0, 0.4]])
def test_interval_of_a_share_is_one_of_shares(values):
    """None of a success ends above 100 % or below 0; that of any other number may."""
    share, number = mean_over_seeds(values, bounds=SHARE), mean_over_seeds(values)
    assert 0.0 <= share.low < share.value < share.high <= 1.0
    assert number.low < 0.0 or number.high > 1.0
