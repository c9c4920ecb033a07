"""The mean over seeds, and how far it can be trusted."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.eta.seed_mean import SeedMean, mean_over_seeds

numbers = st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=12)


@given(numbers)
def test_interval_holds_the_mean_and_stays_among_the_values(values: list[float]):
    """Low <= mean <= high, and no end lies outside of what was seen."""
    found = mean_over_seeds(values)
    slack = 1e-9 * (1.0 + max(map(abs, values)))
    assert found.mean == pytest.approx(sum(values) / len(values), abs=slack)
    assert min(values) - slack <= found.low <= found.high <= max(values) + slack
    assert found.seeds == len(values)


def test_more_seeds_give_a_narrower_interval():
    """The same spread, eight times as many seeds."""
    few, many = mean_over_seeds([0.0, 1.0] * 3), mean_over_seeds([0.0, 1.0] * 24)
    assert many.high - many.low < few.high - few.low


def test_one_seed_has_no_interval():
    """And says so."""
    assert mean_over_seeds([0.5]) == SeedMean(0.5, None, None, 1, ("one seed: no interval",))


def test_no_value_has_the_reason():
    """n/a, never a number that is none."""
    assert mean_over_seeds([], "1 of 1 failed") == SeedMean(None, notes=("1 of 1 failed",))


def test_few_seeds_are_rough():
    """Below five seeds the note says so, beside why others are missing; from five on there is nothing to say."""
    assert mean_over_seeds([0.1, 0.2], "1 of 3 failed").note == (
        "2 seeds: the interval is rough below 5; 1 of 3 failed"
    )
    assert mean_over_seeds([0.1] * 5).note == ""


def test_json_is_plain():
    """Field by field."""
    assert json.loads(json.dumps(mean_over_seeds([0.5]).to_json())) == {
        "mean": 0.5, "low": None, "high": None, "seeds": 1, "note": "one seed: no interval",
    }  # fmt: skip
