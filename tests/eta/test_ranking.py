"""Whether rewards keep their order."""

import numpy as np
import pytest
from scipy.stats import kendalltau

from harness.eta.ranking import rank_agreement

ONE = {"a": [0.1, 0.1, 0.1], "b": [0.5, 0.5, 0.5], "c": [0.9, 0.9, 0.9]}


def test_same_order_is_one_and_the_opposite_minus_one():
    """Whatever the values are."""
    again = {name: [value / 2 for value in values] for name, values in ONE.items()}
    opposite = {name: [1.0 - value for value in values] for name, values in ONE.items()}
    assert rank_agreement([ONE, again]).tau == pytest.approx(1.0)
    assert rank_agreement([ONE, opposite]).tau == pytest.approx(-1.0)


def test_tau_is_that_of_scipy_ties_included():
    """The mean over all pairs of places."""
    rng = np.random.default_rng(1)
    places = rng.integers(0, 4, (4, 6)).astype(float)
    given = [{str(k): [value] * 3 for k, value in enumerate(place)} for place in places]
    pairs = [(i, j) for i in range(4) for j in range(i)]
    expected = np.mean([kendalltau(places[i], places[j]).statistic for i, j in pairs])
    assert rank_agreement(given).tau == pytest.approx(expected)


def test_interval_holds_the_number_and_widens_with_the_noise():
    """Seeds that scatter leave the order open."""
    rng = np.random.default_rng(2)

    def noisy(sigma):
        return [
            {name: (np.mean(values) + sigma * rng.standard_normal(6)).tolist() for name, values in ONE.items()}
            for _ in range(3)
        ]

    sure, unsure = rank_agreement(noisy(0.01)), rank_agreement(noisy(1.0))
    assert (sure.low, sure.tau, sure.high) == (1.0, 1.0, 1.0)
    assert unsure.low <= unsure.tau <= unsure.high
    assert unsure.high - unsure.low > 0.3


def test_interval_is_the_same_each_time():
    """Draws have a seed of their own."""
    given = [{"a": [0.1, 0.4, 0.2], "b": [0.3, 0.5, 0.1], "c": [0.6, 0.2, 0.4]}] * 2
    assert rank_agreement(given) == rank_agreement(given)


@pytest.mark.parametrize(
    ("places", "told"),
    [
        ([], "it takes 3 rewards in 2 places; here are 0 in 0"),
        ([ONE], "here are 3 in 1"),
        ([{"a": [0.1], "b": [0.2]}] * 2, "here are 2 in 2"),
        ([ONE, {"a": [0.1], "b": [0.2], "d": [0.3]}], "here are 2 in 2"),
        ([ONE, dict.fromkeys("abc", [0.5] * 3)], "no order"),
    ],
)
def test_what_has_no_order_says_why(places, told):
    """And is no number."""
    ranking = rank_agreement(places)
    assert (ranking.tau, ranking.low) == (None, None)
    assert told in ranking.note


def test_one_seed_has_no_interval():
    """There is nothing to draw from."""
    ranking = rank_agreement([{"a": [0.1], "b": [0.2], "c": [0.3]}] * 2)
    assert (ranking.tau, ranking.low, ranking.note) == (pytest.approx(1.0), None, "too few seeds for an interval")
