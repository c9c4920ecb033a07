"""The logarithmic axis that ratios stand on."""

import math
from itertools import pairwise

from harness.eta import Ratio
from harness.report.figures.ratio_axis import (
    interval_ends,
    is_drawable,
    named_ticks,
    ratio_range,
    ticks,
)

NEAR_ZERO = "I_N of the baseline is near zero beside I_P of the same runs"


def test_ticks_are_few_and_hold_one(subtests):
    """Wherever the axis ends, 1 is marked, and the marks are in order and have room."""
    for span in [(0.8, 1.2), (0.5, 2.0), (0.1, 3.0), (0.01, 40.0), (1e-9, 1e9), (0.97, 1.03)]:
        with subtests.test(span=span):
            marks = ticks(*span)
            assert 1.0 in marks
            assert marks == sorted(set(marks))
            assert len(marks) <= 10
            assert all(span[0] <= mark <= span[1] for mark in marks)


def test_what_has_no_logarithm_is_not_drawn():
    """Neither is what says little, and what is not there."""
    assert is_drawable(Ratio(0.2))
    assert not any(map(is_drawable, (Ratio(0.0), Ratio(-1.0), Ratio(None), Ratio(2.0, near_zero=NEAR_ZERO))))


def test_range_holds_what_is_drawn_and_one():
    """A ratio that says little does not stretch it; without any it is an axis around 1."""
    low, high = ratio_range([Ratio(3.0, 2.0, 9.0), Ratio(1e9, near_zero=NEAR_ZERO)])
    assert low < 1.0
    assert 9.0 < high < 20.0
    low, high = ratio_range([])
    assert 0.5 < low < 1.0 < high < 2.0


def test_endless_interval_is_cut():
    """An interval far beyond the ratios ends with the axis; the ratio keeps its place."""
    wide = Ratio(2.0, 1.0, 1e30)
    low, high = ratio_range([wide])
    assert 60.0 < high < 90.0
    assert interval_ends(wide, low, high) == (1.0, high)
    assert interval_ends(Ratio(2.0), low, high) is None


def test_names_of_ticks_keep_apart(subtests):
    """By half a character or more, whatever the axis spans; 1 is always among them."""
    for low in [0.95, 0.5, 0.05, 0.001, 2e-4, 1e-5, 1e-8]:
        for high in [1.3, 2.0, 20.0, 3e3, 1e8]:
            with subtests.test(low=low, high=high):
                named = named_ticks(low, high)
                ends = [
                    (26 * math.log(value / low) / math.log(high / low) + sign * len(name) / 2)
                    for value, name in named
                    for sign in (-1, 1)
                ]
                assert min((right - left for left, right in pairwise(ends[1:-1])), default=1.0) >= 0.5
                assert "1" in {name for _, name in named}
    assert [name for _, name in named_ticks(1e-7, 1e7)] == ["1e-6", "0.001", "1", "1,000", "1e6"]
