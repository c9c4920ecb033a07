"""Two rewards beside one another in the steps of a recording."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from harness.log import Failed, LogFacts, in_memory
from harness_plugins.audit.recorded.pair import Apart, Paid, compare_paid, paid_in, pairs_in

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
    order = compare_paid(paid(one, other), "one", "other")
    assert order.told_apart == pytest.approx(len(pairs) / (len(one) * (len(one) - 1) / 2))
    assert order.discordant == (pytest.approx(opposite / len(pairs)) if pairs else None)


@given(NUMBERS, st.sampled_from([0.5, 3.0]), st.integers(-5, 5))
def test_scale_and_offset_are_no_distance(values, scale, offset):
    """Neither in steps nor in returns, nor in the order of episodes."""
    apart = compare_paid(paid(values, scale * np.array(values) + offset), "one", "other")
    assert (apart.steps, apart.returns) == (pytest.approx(0.0, abs=1e-7), pytest.approx(0.0, abs=1e-7))
    assert apart.discordant in {0.0, None}


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
    assert (apart.steps, apart.discordant, apart.told_apart) == (pytest.approx(1.0), 1.0, 1.0)


def test_constant_reward_has_no_distance():
    """It tells nothing apart."""
    apart = compare_paid(paid([1, 2, 3], [5, 5, 5]), "one", "other")
    assert apart == Apart(None, None, None, 0.0)


def test_single_episode_has_no_order():
    """Nor a distance of returns."""
    apart = compare_paid(paid([1], [2]), "one", "other")
    assert (apart.returns, apart.discordant, apart.told_apart) == (None, None, None)


def test_returns_that_differ_by_rounding_are_equal():
    """0.1 + 0.2 is 0.3 here."""
    assert compare_paid(paid([0.1 + 0.2, 0.3], [1, 2]), "one", "other").discordant is None


def log_of(unit="step", failed=(), **columns):
    """Of one training."""
    facts = LogFacts(path=Path("log"), format="made", unit=unit, failed=failed)
    return in_memory(facts, {name.replace("__", "/"): np.asarray(values) for name, values in columns.items()})


def test_steps_and_episodes_of_a_log_are_paid():
    """Of envs that take turns; an episode that has not ended is left out, and its steps are not."""
    log = log_of(
        env=[0, 1, 0, 1, 0, 1],
        episode=[0, 0, 0, 0, 1, 0],
        terminated=[False, False, True, False, False, False],
        truncated=[False, False, False, False, False, True],
        reward__a=[1.0, 10.0, 2.0, 20.0, 4.0, 30.0],
    )
    paid = paid_in(log)
    assert (paid.returns["a"].tolist(), paid.steps["a"].tolist()) == ([3.0, 60.0], [1.0, 10.0, 2.0, 20.0, 4.0, 30.0])


def test_start_of_an_episode_is_no_step():
    """It is paid nothing, and is not compared."""
    starts, ends = [True, False, False, True, False, False], [False, False, True, False, False, True]
    paid = {"reward__a": [99.0, 1.0, 2.0, 99.0, 3.0, 5.0], "reward__b": [-99.0, 2.0, 4.0, -99.0, 6.0, 10.0]}
    log = log_of(start=starts, terminated=ends, episode=[0, 0, 0, 1, 1, 1], **paid)
    ((pair,), _) = pairs_in([("some", log)], ("a", "b"))
    assert pair.steps.mean == pytest.approx(0.0, abs=1e-7)


def test_rows_of_episodes_are_compared_by_episodes_alone():
    """There are no steps to compare."""
    log = log_of(unit="episode", reward__a=[1.0, 2.0, 4.0], reward__b=[2.0, 4.0, 8.0])
    apart = compare_paid(paid_in(log), "a", "b")
    assert (apart.steps, apart.returns, apart.discordant) == (None, pytest.approx(0.0, abs=1e-7), 0.0)


def test_reward_that_was_given_up_says_why():
    """It is known in no step then."""
    failed = (Failed("reward/a", "it broke"),)
    log = log_of(failed=failed, terminated=[True, True], reward__a=[1.0, np.nan], reward__b=[1.0, 2.0])
    paid = paid_in(log)
    assert (paid.unknown, set(paid.returns)) == ({"a": "given up: it broke"}, {"b"})
