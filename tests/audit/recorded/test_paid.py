"""Two rewards beside one another in the steps of a recording."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.audit.recorded.paid import Paid, compare_paid

NUMBERS = st.lists(st.integers(-20, 20), min_size=2, max_size=12)


def paid(one, other) -> Paid:
    """Each step is an episode."""
    values = {"one": np.asarray(one, float), "other": np.asarray(other, float)}
    return Paid(values, values, {})


@given(st.lists(st.tuples(st.integers(-9, 9), st.integers(-9, 9)), min_size=2, max_size=12))
def test_order_is_what_counting_pairs_gives(values):
    """Ties of either reward are left out of the share, and told."""
    one, other = np.array(values).T
    pairs = [(a, b) for a, b in combinations(range(len(one)), 2) if one[a] != one[b] and other[a] != other[b]]
    opposite = sum((one[a] < one[b]) != (other[a] < other[b]) for a, b in pairs)
    order = compare_paid(paid(one, other), "one", "other").order
    assert order.told_apart == pytest.approx(len(pairs) / (len(one) * (len(one) - 1) / 2))
    assert order.discordant == (pytest.approx(opposite / len(pairs)) if pairs else None)


@given(NUMBERS, st.sampled_from([0.5, 3.0]), st.integers(-5, 5))
def test_scale_and_offset_are_no_distance(values, scale, offset):
    """Neither in steps nor in returns, nor in the order of episodes."""
    apart = compare_paid(paid(values, scale * np.array(values) + offset), "one", "other")
    assert (apart.steps, apart.returns) == (pytest.approx(0.0, abs=1e-7), pytest.approx(0.0, abs=1e-7))
    assert apart.order.discordant in {0.0, None}


@given(NUMBERS, st.data())
def test_distance_is_symmetric_and_from_0_to_1(values, data):
    """As is the share of episodes in another order."""
    both = paid(values, data.draw(st.lists(st.integers(-20, 20), min_size=len(values), max_size=len(values))))
    there, back = compare_paid(both, "one", "other"), compare_paid(both, "other", "one")
    assert there == back
    assert there.steps is None or 0.0 <= there.steps <= 1.0


def test_opposite_rewards_are_1_apart():
    """And every pair of episodes stands in the opposite order."""
    apart = compare_paid(paid([1, 2, 4], [-1, -2, -4]), "one", "other")
    assert (apart.steps, apart.order) == (pytest.approx(1.0), (1.0, 1.0))


def test_constant_reward_has_no_distance():
    """It tells nothing apart."""
    apart = compare_paid(paid([1, 2, 3], [5, 5, 5]), "one", "other")
    assert (apart.steps, apart.returns, apart.order) == (None, None, (None, 0.0))


def test_single_episode_has_no_order():
    """Nor a distance of returns."""
    apart = compare_paid(paid([1], [2]), "one", "other")
    assert (apart.returns, apart.order) == (None, (None, None))


def test_returns_that_differ_by_rounding_are_equal():
    """0.1 + 0.2 is 0.3 here."""
    assert compare_paid(paid([0.1 + 0.2, 0.3], [1, 2]), "one", "other").order == (None, 0.0)


def test_sum_knows_what_both_know():
    """The reasons of the others stay."""
    both = paid([1, 2], [3, 4]) + Paid({"one": np.array([5.0])}, {"one": np.array([5.0])}, {"other": "given up"})
    assert both.steps["one"].tolist() == [1, 2, 5]
    assert (set(both.steps), both.unknown) == ({"one"}, {"other": "given up"})
