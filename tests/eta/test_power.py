"""How many seeds it takes: against what so many seeds show in simulated experiments."""

import numpy as np
import pytest
from numpy.random import default_rng

from harness.eta import Question
from harness.eta.power import FEWEST, POWER, seeds_to_tell

ENDS = np.array([[[0.0, 1.0]]])


def found(baseline, difference, spread, seeds, confidence, experiments=400):
    """How often the bound of so many trainings leaves out 0."""
    rng, told = default_rng(seeds), 0
    for _ in range(experiments):
        values = (
            baseline + spread * rng.normal(size=(2, seeds, 1, 1)) + np.array([0.0, difference])[:, None, None, None]
        )
        told += Question.of(np.clip(values, 0.0, 1.0), ENDS).leaning(0, confidence) == 1
    return told / experiments


@pytest.mark.parametrize(
    ("baseline", "difference", "spread"), [(0.45, 0.2, 0.18), (0.45, 0.3, 0.18), (0.8, 0.1, 0.02), (0.3, 0.5, 0.15)]
)
@pytest.mark.parametrize("confidence", [0.95, 0.9875])
def test_so_many_trainings_are_enough_and_hardly_more(baseline, difference, spread, confidence):
    """Where the spread is the largest likely one, four of five experiments tell; Monte Carlo error 0.02."""
    known = spread / seeds_to_spread(1000)
    low, high = seeds_to_tell(difference, known, 1000, confidence, baseline + difference)
    assert low <= high
    assert found(baseline, difference, spread, high + 1, confidence) >= POWER - 0.06
    assert found(baseline, difference, spread, max(2, low - 4), confidence) <= POWER + 0.06


def seeds_to_spread(seeds):
    """By how much the largest likely spread of so many seeds is larger than the one that was seen."""
    from harness.eta.interval import spread_range

    return spread_range(1.0, 2 * seeds - 1)[1]


def test_few_seeds_know_their_spread_roughly():
    """So the range is wide; smaller differences take more, and beyond MOST nobody would run them."""
    few, many = (seeds_to_tell(0.2, 0.18, seeds, 0.95, 0.65) for seeds in (3, 100))
    assert few[0] <= many[0] <= many[1] <= few[1]
    assert few[1] - few[0] > many[1] - many[0]
    told = [seeds_to_tell(size, 0.18, 10, 0.95, 0.7) for size in (0.4, 0.2, 0.1, 0.05)]
    assert told == sorted(told)
    assert seeds_to_tell(1e-4, 0.18, 10, 0.95, 0.7) is None


def test_fewer_than_four_never_tell():
    """However large the difference is: a fourth, unseen one could undo it."""
    assert seeds_to_tell(1.0, 0.0, 5, 0.95, 1.0) == (FEWEST, FEWEST)
    for seeds, leaning in ((FEWEST - 1, 0), (FEWEST, 1)):
        values = np.stack([np.zeros((seeds, 1, 1)), np.ones((seeds, 1, 1))])
        assert Question.of(values, ENDS).leaning(0, 0.95) == leaning
