"""How many seeds it takes: against what so many seeds show in simulated experiments."""

import numpy as np
import pytest

from harness.eta import Question, rule
from harness.eta.power import MOST, POWER, fewest_seeds, seeds_to_tell

LEVEL = 0.05


def tell(difference: float, spread: float, seeds: int, asked: int) -> tuple[int, int] | None:
    """At 5 %."""
    return seeds_to_tell(difference, spread, seeds, asked, LEVEL)


def found(difference: float, seeds: int, asked: int, experiments: int = 200, measures: int = 1) -> float:
    """How often so many seeds show a difference, in standard deviations of a training, among questions without one.

    Of several measures only the first shows it.
    """
    rng = np.random.default_rng([seeds, asked])
    values = rng.normal(size=(experiments, asked, 2, seeds, 1, measures))
    values[:, 0, 1, ..., 0] += difference
    return float(np.mean([rule([Question.of(each) for each in one])[0].is_decided for one in values]))


@pytest.mark.parametrize("difference", [1.0, 1.5])
@pytest.mark.parametrize("claims", [1, 4])
def test_high_end_is_enough(difference, claims):
    """Where the spread is the largest likely one, four of five experiments show it; Monte Carlo error 0.028."""
    pilot = 10
    largest = 1.0  # of the differences that are drawn; these seeds have shown less
    shown = largest * (np.sqrt(18.0 / 10.865) ** -1)  # 10.865: the tenth of chi-square with 18 degrees of freedom
    told = tell(difference, float(shown), pilot, claims)
    assert told is not None
    assert found(difference, told[1], claims) > POWER - 3.0 * 0.028


def test_high_end_is_enough_where_one_of_three_measures_shows_it():
    """They count as three tests; Monte Carlo error 0.028."""
    shown = np.sqrt(10.865 / 18.0)
    told = tell(1.5, float(shown), 10, 3)
    assert told is not None
    assert found(1.5, told[1], 1, measures=3) > POWER - 3.0 * 0.028
    assert found(1.5, told[1] - 3, 1, measures=3) < POWER


@pytest.mark.slow
@pytest.mark.parametrize("pilot", [3, 10])
def test_experiments_of_the_high_end_mostly_have_the_power(pilot):
    """The spread of a few seeds is known roughly: nine of ten pilots ask for enough."""
    rng = np.random.default_rng(pilot)
    spreads = np.sqrt(rng.normal(size=(300, 2, pilot)).var(axis=2, ddof=1).mean(axis=1))
    told = [tell(1.5, spread, pilot, 1) for spread in spreads]
    asked = [range_[1] for range_ in told if range_ is not None]
    enough = min(seeds for seeds in range(5, 14) if found(1.5, seeds, 1, 600) >= POWER - 0.02)
    assert np.mean(np.array(asked) >= enough) >= 0.9 - 3.0 * 0.017


def test_low_end_takes_the_smallest_likely_spread_and_one_claim():
    """Fewer seeds than that hardly ever tell."""
    told = tell(1.0, 1.0, 10, 1)
    more = tell(1.0, 1.0, 10, 100)
    assert told is not None
    assert more is not None
    assert told[0] == more[0] < told[1] < more[1]
    assert found(np.sqrt(25.99 / 18.0), told[0], 1) > POWER - 3.0 * 0.028
    assert found(np.sqrt(25.99 / 18.0), told[0] - 3, 1) < POWER


@pytest.mark.parametrize(("claims", "fewest"), [(1, 4), (28, 7)])
def test_no_seeds_tell_that_cannot_show_anything(claims, fewest):
    """However large the difference: also where scipy's distribution has no number any more."""
    assert fewest_seeds(0.05 / claims) == fewest
    for difference in (5.0, 12.0, 20.0, 100.0, 1e6):
        told = tell(difference, 1.0, 10, claims)
        assert told == (4, fewest)


def test_seeds_without_a_spread():
    """Nothing varies: the fewest that can show anything."""
    assert tell(0.1, 0.0, 5, 1) == (4, 4)


def test_smaller_differences_take_more_seeds():
    """At both ends."""
    ranges = [tell(difference, 1.0, 10, 10) for difference in (2.0, 1.0, 0.5, 0.3)]
    for end in (0, 1):
        numbers = [told[end] for told in ranges if told is not None]
        assert numbers == sorted(set(numbers))


def test_hopeless_numbers_are_not_told():
    """Beyond MOST nobody would run them."""
    assert tell(0.01, 1.0, 10, 1) is None
    told = tell(0.2, 1.0, 10, 1)
    assert told is not None
    assert told[1] <= MOST


def test_thousands_of_seeds_are_a_number():
    """A difference that is small beside the spread takes many seeds, not an error; a smaller one cannot be told."""
    low, high = tell(0.08, 1.0, 10, 1) or (0, 0)
    assert 1_000 < low < high <= 10_000
    assert tell(1e-4, 1.0, 10, 1) is None
