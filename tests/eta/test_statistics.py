"""How far a difference can be trusted: draws, intervals, p-values and their correction."""

import math
import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.eta.statistics import (
    CONFIDENCE,
    MANY_SEEDS,
    RESAMPLES,
    draw_shares,
    holm,
    p_value,
    percentile_interval,
    seeds_to_decide,
    split_halves,
)

P_VALUES = st.lists(st.floats(0.0, 1.0), min_size=1, max_size=8)


# Draws


@pytest.mark.parametrize("count", [1, 2, 5, 30])
def test_shares_are_of_draws_with_replacement(count: int):
    """Each draw takes as many seeds as there are: whole numbers of them, which add up to all."""
    drawn = draw_shares(count) * count
    assert drawn.shape == (RESAMPLES, count)
    np.testing.assert_allclose(drawn, np.round(drawn), atol=1e-9)
    np.testing.assert_allclose(drawn.sum(axis=1), count)


def test_seeds_are_drawn_equally_often():
    """No seed counts more than another, and one is left out as often as it has to be."""
    shares = draw_shares(5)
    np.testing.assert_allclose(shares.mean(axis=0), 0.2, atol=0.01)
    np.testing.assert_allclose((shares == 0.0).mean(axis=0), 0.8**5, atol=0.03)


def test_same_stream_draws_the_same():
    """Paired groups take one stream, others take two; nothing else decides."""
    np.testing.assert_array_equal(draw_shares(5, 1), draw_shares(5, 1))
    assert (draw_shares(5, 0) != draw_shares(5, 1)).any()


def test_halves_are_disjoint_and_equally_large():
    """Each seed is in one half at most; of an odd number one is in none."""
    for count in (4, 5, 8):
        first, second = split_halves(count)
        assert first.shape == second.shape == (200, count)
        assert not (first * second).any()
        for half in (first, second):
            np.testing.assert_array_equal((half > 0.0).sum(axis=1), count // 2)
            np.testing.assert_allclose(half.sum(axis=1), 1.0)


def test_halves_differ():
    """They are drawn at random, every seed now in the one, now in the other, and the same each time."""
    first, second = split_halves(6)
    assert (first.any(axis=0) & second.any(axis=0)).all()
    np.testing.assert_array_equal(first, split_halves(6)[0])


# Intervals


def test_interval_is_the_middle_of_the_draws():
    """Between the quantiles that leave out half of the rest on each side."""
    low, high = percentile_interval(np.arange(1001.0))
    assert (low, high) == pytest.approx((25.0, 975.0))
    assert CONFIDENCE == 0.95


def test_interval_does_not_know_the_order_of_the_draws():
    """Draws are a set."""
    values = np.random.default_rng(0).normal(size=501)
    assert percentile_interval(values) == percentile_interval(values[::-1])


@given(st.lists(st.floats(0.01, 100.0), min_size=1, max_size=50))
def test_interval_of_ratios_is_nearly_that_of_their_logarithms(values: list[float]):
    """Percentiles keep order: the logarithm of an end lies between the same two draws' logarithms."""
    ratios = np.array(values)
    for end, logarithm in zip(percentile_interval(ratios), percentile_interval(np.log(ratios)), strict=True):
        below, above = ratios[ratios <= end * (1 + 1e-12)].max(), ratios[ratios >= end * (1 - 1e-12)].min()
        assert math.log(below) - 1e-9 <= logarithm <= math.log(above) + 1e-9


# p-values


def test_p_value_counts_the_far_side_twice():
    """Of 999 draws 24 lie beyond the null: 2 x 25 / 1000, the null itself counted among them."""
    values = np.concatenate([np.full(24, 0.5), np.full(975, 2.0)])
    assert p_value(values, 1.0) == pytest.approx(0.05)
    assert p_value(-values, -1.0) == pytest.approx(0.05)


def test_p_value_is_never_zero_and_never_above_one():
    """Draws cannot exclude anything for sure, and a draw on the null counts for both sides."""
    assert p_value(np.full(1999, 2.0), 1.0) == pytest.approx(0.001)
    assert p_value(np.full(1999, 1.0), 1.0) == 1.0


def test_p_value_agrees_with_the_interval():
    """Beyond 5 % means: the null is outside of the 95 % interval."""
    values = np.random.default_rng(1).normal(size=RESAMPLES)
    low, high = percentile_interval(values)
    for null, outside in ((low - 0.05, True), (low + 0.05, False), (high - 0.05, False), (high + 0.05, True)):
        assert (p_value(values, null) < 0.05) == outside


# Several comparisons


def test_holm_by_hand():
    """The smallest p-value counts four times, the next three times, and none is smaller than the one before."""
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])


def test_holm_of_one_or_none():
    """A single comparison needs no correction."""
    assert holm([0.04]) == [0.04]
    assert holm([]) == []


@given(P_VALUES)
def test_holm_bounds(p_values: list[float]):
    """Never smaller than without correction, never larger than Bonferroni's, never above 1."""
    for raw, corrected in zip(p_values, holm(p_values), strict=True):
        assert raw <= corrected <= min(1.0, raw * len(p_values))


@given(P_VALUES)
def test_holm_keeps_the_order(p_values: list[float]):
    """What was smaller stays no larger."""
    corrected = [value for _, value in sorted(zip(p_values, holm(p_values), strict=True))]
    assert corrected == sorted(corrected)


@given(P_VALUES, st.sampled_from([0.01, 0.05, 0.2]))
def test_holm_rejects_what_the_step_down_procedure_rejects(p_values: list[float], alpha: float):
    """Corrected p-values below a level are those that Holm's procedure, written as it is taught, rejects at it."""
    rejected = set()
    for rank, i in enumerate(sorted(range(len(p_values)), key=lambda i: p_values[i])):
        if p_values[i] * (len(p_values) - rank) > alpha:
            break
        rejected.add(i)
    assert {i for i, corrected in enumerate(holm(p_values)) if corrected <= alpha} == rejected


# How many seeds


def draws_around(ratio: float, spread: float) -> np.ndarray:
    """Ratios whose logarithms have this mean and this standard deviation."""
    draws = random.Random(0)
    logs = np.array([draws.gauss(0.0, 1.0) for _ in range(2000)])
    return np.exp(math.log(ratio) + spread * (logs - logs.mean()) / logs.std())


def test_seeds_to_decide_by_hand():
    """The interval shrinks as 1 / sqrt(seeds): it has to get 1.96 spreads within log(ratio)."""
    # 5 seeds, spread 0.5, log(ratio) 0.25: (1.96 x 0.5 / 0.25)^2 = 15.3664 times as many
    assert seeds_to_decide(draws_around(math.exp(0.25), 0.5), math.exp(0.25), 5) == 77


def test_seeds_to_decide_is_the_same_for_a_ratio_and_its_inverse():
    """Which of the two is the baseline does not matter."""
    draws = draws_around(1.3, 0.4)
    assert seeds_to_decide(draws, 1.3, 6) == seeds_to_decide(1.0 / draws, 1.0 / 1.3, 6)


def test_seeds_that_decide_already_are_enough():
    """Never fewer than there are."""
    assert seeds_to_decide(draws_around(3.0, 0.01), 3.0, 6) == 6
    assert seeds_to_decide(np.full(100, 2.0), 2.0, 6) == 6


@pytest.mark.parametrize(
    ("draws", "ratio"),
    [
        (np.full(100, 1.0), 1.0),
        (np.array([2.0, 0.0]), 1.5),
        (np.array([2.0, -1.0]), 1.5),
        (np.array([-2.0, -1.0]), -1.5),
        (np.array([0.0, 0.0]), 0.0),
    ],
)
def test_number_of_seeds_that_cannot_be_told(draws: np.ndarray, ratio: float):
    """A ratio of exactly 1, or one without a logarithm, in the value or in a draw."""
    assert seeds_to_decide(draws, ratio, 5) is None


def test_hopeless_numbers_of_seeds_are_not_told():
    """Beyond MANY_SEEDS nobody would run them."""
    assert seeds_to_decide(draws_around(1.001, 0.5), 1.001, 5) is None
    assert seeds_to_decide(draws_around(1.1, 0.5), 1.1, 5) <= MANY_SEEDS
