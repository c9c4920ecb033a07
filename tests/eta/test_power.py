"""How many seeds it takes: against what so many seeds show in simulated experiments."""

import numpy as np
import pytest
from numpy.random import default_rng

from harness.eta import Question, rule
from harness.eta.power import seeds_to_tell


def tell(difference, spread, seeds, asked):
    """At 5 %; (0, 0) where nobody would run so many."""
    return seeds_to_tell(difference, spread, seeds, asked, 0.05) or (0, 0)


def found(difference, seeds, asked, experiments=200, measures=1):
    """How often so many seeds show a difference, in standard deviations of a training, among questions without one.

    Of several measures only the first shows it.
    """
    values = default_rng([seeds, asked]).normal(size=(experiments, asked, 2, seeds, 1, measures))
    values[:, 0, 1, ..., 0] += difference
    return float(np.mean([rule([Question.of(each) for each in one])[0].is_decided for one in values]))


SHOWN = (10.865 / 18.0) ** 0.5
"""What ten seeds show where 1 is the largest likely spread; 10.865: the tenth of chi-square, 18 degrees of freedom."""


@pytest.mark.parametrize("difference", [1.0, 1.5])
@pytest.mark.parametrize("claims", [1, pytest.param(4, marks=pytest.mark.slow)])
def test_high_end_is_enough(difference, claims):
    """Where the spread is the largest likely one, four of five experiments show it; Monte Carlo error 0.028."""
    assert found(difference, tell(difference, SHOWN, 10, claims)[1], claims) > 0.8 - 3.0 * 0.028


def test_high_end_is_enough_where_one_of_three_measures_shows_it():
    """They count as three tests; Monte Carlo error 0.028."""
    seeds = tell(1.5, SHOWN, 10, 3)[1]
    assert found(1.5, seeds, 1, measures=3) > 0.8 - 3.0 * 0.028
    assert found(1.5, seeds - 3, 1, measures=3) < 0.8


@pytest.mark.slow
@pytest.mark.parametrize("pilot", [3, 10])
def test_experiments_of_the_high_end_mostly_have_the_power(pilot):
    """The spread of a few seeds is known roughly: nine of ten pilots ask for enough."""
    spreads = default_rng(pilot).normal(size=(300, 2, pilot)).var(axis=2, ddof=1).mean(axis=1) ** 0.5
    told = [tell(1.5, spread, pilot, 1)[1] for spread in spreads]
    enough = min(seeds for seeds in range(5, 14) if found(1.5, seeds, 1, 600) >= 0.8 - 0.02)
    assert np.mean(np.array([it for it in told if it]) >= enough) >= 0.9 - 3.0 * 0.017


def test_low_end_takes_the_smallest_likely_spread_and_one_claim():
    """Fewer seeds than that hardly ever tell."""
    told, more = tell(1.0, 1.0, 10, 1), tell(1.0, 1.0, 10, 100)
    assert told[0] == more[0] < told[1] < more[1]
    assert found(np.sqrt(25.99 / 18.0), told[0], 1) > 0.8 - 3.0 * 0.028
    assert found(np.sqrt(25.99 / 18.0), told[0] - 3, 1) < 0.8


@pytest.mark.parametrize(("claims", "fewest"), [(1, 4), (28, 7)])
def test_no_seeds_tell_that_cannot_show_anything(claims, fewest):
    """However large the difference: also where scipy's distribution has no number any more, or nothing varies."""
    for difference in (5.0, 12.0, 20.0, 100.0, 1e6):
        assert tell(difference, 1.0, 10, claims) == (4, fewest)
    assert tell(0.1, 0.0, 5, 1) == (4, 4)


def test_smaller_differences_take_more_seeds():
    """At both ends; thousands are a number, beyond MOST nobody would run them."""
    for numbers in zip(*(tell(difference, 1.0, 10, 10) for difference in (2.0, 1.0, 0.5, 0.3)), strict=True):
        assert list(numbers) == sorted(set(numbers))
    low, high = tell(0.08, 1.0, 10, 1)
    assert 1_000 < low < high <= 10_000
    assert tell(0.2, 1.0, 10, 1)[1] <= 10_000
    assert tell(0.01, 1.0, 10, 1) == tell(1e-4, 1.0, 10, 1) == (0, 0)
