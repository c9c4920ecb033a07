"""How many seeds it takes: against what so many seeds show in simulated experiments."""

import numpy as np
import pytest

from harness.eta.power import MOST, POWER, seeds_to_tell
from harness.eta.swaps import corrected_p, fewest_seeds, swaps_of


def found(difference: float, seeds: int, claims: int, experiments: int = 300) -> float:
    """How often so many seeds show a difference, in standard deviations of theirs, among claims without one."""
    rng = np.random.default_rng([seeds, claims])
    signs = swaps_of(range(seeds)).signs
    some = signs if len(signs) <= 1024 else signs[np.r_[0, rng.integers(1, len(signs), 1023)]]
    values = rng.normal(size=(experiments, seeds, claims))
    values[:, :, 0] += difference
    return float(np.mean([corrected_p(list((some @ each).T))[0] <= 0.05 for each in values]))


@pytest.mark.parametrize("difference", [0.7, 1.0, 1.5])
@pytest.mark.parametrize("claims", [1, 28])
def test_high_end_is_enough(difference: float, claims: int):
    """Where the spread is the largest likely one, four of five experiments show it; Monte Carlo error 0.023."""
    pilot = 10
    largest = 1.0  # of the differences that are drawn; these seeds have shown less
    shown = largest * (np.sqrt(9.0 / 4.168) ** -1)  # 4.168: the tenth of chi-square with 9 degrees of freedom
    told = seeds_to_tell(difference, float(shown), pilot, claims)
    assert told is not None
    assert found(difference, told[1], claims) > POWER - 3.0 * 0.023


@pytest.mark.parametrize("pilot", [3, 10])
def test_experiments_of_the_high_end_mostly_have_the_power(pilot: int):
    """The spread of a few seeds is known roughly: nine of ten pilots ask for enough."""
    rng = np.random.default_rng(pilot)
    spreads = rng.normal(size=(300, pilot)).std(axis=1, ddof=1)
    told = [seeds_to_tell(1.2, spread, pilot, 1) for spread in spreads]
    asked = [range_[1] for range_ in told if range_ is not None]
    enough = min(seeds for seeds in range(6, 20) if found(1.2, seeds, 1, 1000) >= POWER - 0.02)
    assert np.mean(np.array(asked) >= enough) >= 0.9 - 3.0 * 0.017


def test_low_end_takes_the_smallest_likely_spread_and_one_claim():
    """Fewer seeds than that hardly ever tell."""
    told = seeds_to_tell(1.0, 1.0, 10, 1)
    more = seeds_to_tell(1.0, 1.0, 10, 100)
    assert told is not None
    assert more is not None
    assert told[0] == more[0] < told[1] < more[1]
    assert found(np.sqrt(14.68 / 9.0), told[0], 1) > POWER - 3.0 * 0.023
    assert found(np.sqrt(14.68 / 9.0), told[0] - 2, 1) < POWER


@pytest.mark.parametrize(("claims", "fewest"), [(1, 6), (28, 11)])
def test_no_seeds_tell_that_cannot_show_anything(claims: int, fewest: int):
    """However large the difference: also where scipy's distribution has no number any more."""
    assert fewest_seeds(0.05 / claims) == fewest
    for difference in (5.0, 12.0, 20.0, 100.0, 1e6):
        told = seeds_to_tell(difference, 1.0, 10, claims)
        assert told == (6, fewest)


def test_seeds_without_a_spread():
    """Nothing varies: the fewest that can show anything."""
    assert seeds_to_tell(0.1, 0.0, 5, 1) == (6, 6)


def test_smaller_differences_take_more_seeds():
    """At both ends."""
    ranges = [seeds_to_tell(difference, 1.0, 10, 10) for difference in (2.0, 1.0, 0.5, 0.3)]
    for end in (0, 1):
        numbers = [told[end] for told in ranges if told is not None]
        assert numbers == sorted(set(numbers))


def test_hopeless_numbers_are_not_told():
    """Beyond MOST nobody would run them."""
    assert seeds_to_tell(0.01, 1.0, 10, 1) is None
    told = seeds_to_tell(0.2, 1.0, 10, 1)
    assert told is not None
    assert told[1] <= MOST


def test_thousands_of_seeds_are_a_number():
    """A difference that is small beside the spread takes many seeds, not an error; a smaller one cannot be told."""
    low, high = seeds_to_tell(0.05, 1.0, 10, 1) or (0, 0)
    assert 1_000 < low < high <= 10_000
    assert seeds_to_tell(1e-4, 1.0, 10, 1) is None
