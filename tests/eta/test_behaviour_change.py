"""The change of one measure of behaviour: means, the interval of their difference, its test and its direction."""

import json
from dataclasses import replace

import numpy as np
import pytest
import scipy.stats
from hypothesis import assume, given, strategies as st
from numpy.random import default_rng

from harness.eta import SHARE, Quantity, change_of, p_of, swaps_of
from harness.eta.headline import is_within
from harness.eta.interval import Side, difference_bounds
from tests.results.told import SUCCESS

NUMBER = st.floats(-10.0, 10.0).map(lambda value: round(value, 6))
VALUES = st.lists(st.none() | NUMBER, min_size=1, max_size=8)
DISTANCE = Quantity("final_distance", "m", "lower", "deterministic")


def change(baseline, proposed, measure=DISTANCE, random=None):
    """Of seeds 0, 1, 2 ..."""
    one, other = dict(enumerate(baseline)), dict(enumerate(proposed))
    return change_of(measure, one, other, swaps_of(range(len(baseline))), random or [])


def corrected(found, p=None):
    """As a family's only claim, or with this p-value."""
    return replace(found, corrected=found.p if p is None else p)


# Means and differences


def test_means_over_seeds():
    """Under the baseline, under the proposed reward, and of random actions."""
    found = change([0.25, 0.75], [1.0, 0.5], random=[0.0, 0.0, None, 0.25])
    assert (found.baseline, found.proposed, found.difference) == (0.5, 0.75, 0.25)
    assert found.random == pytest.approx(0.25 / 3.0)


def test_metric_that_is_not_defined_is_none():
    """Steps to a target that is never reached: no number, rather than NaN."""
    found = change([None, None], [0.5, None])
    assert (found.baseline, found.proposed, found.random) == (None, 0.5, None)
    assert (found.counts, found.without) == ((0, 1), (2, 1))
    assert (found.difference, found.low, found.high, found.p, found.spread) == (None,) * 5
    assert corrected(found).direction == ""


def test_every_training_with_a_value_is_compared():
    """Trainings of one seed are no pair."""
    found = change([1.0, None, 3.0, 5.0], [2.0, 9.0, 4.0, None])
    assert (found.counts, found.without, found.can_decide) == ((3, 3), (1, 1), False)
    assert (found.baseline, found.proposed, found.difference) == (3.0, 5.0, 2.0)


def test_one_reward_may_have_more_trainings():
    """Under seeds that the other one lacks; a hint swaps names in those that both have."""
    found = change_of(DISTANCE, {3: 1.0, 5: 9.0, 6: 2.0}, {5: 9.5, 3: 1.5}, swaps_of([3, 5, 6]))
    assert (found.counts, found.seeds, found.can_decide) == ((3, 2), 2, True)
    assert found.outcomes[0] == pytest.approx(0.5)
    assert np.abs(found.outcomes).max() == pytest.approx(0.5)


def test_who_failed_is_counted_of_a_share_of_which_more_is_better():
    """Less than half of the episodes succeed."""
    values = ([0.49, 0.5, 1.0], [0.0, 0.1, 0.9])
    assert change(*values, SUCCESS).failed == (1, 2)
    assert change(*values, SUCCESS._replace(better="lower")).failed is None
    assert change(*values).failed is None


# Intervals


@given(st.lists(st.tuples(NUMBER, NUMBER), min_size=3, max_size=10))
def test_interval_is_that_of_welchs_t_test(pairs):
    """Scipy's."""
    one, other = zip(*pairs, strict=True)
    assume(min(np.std(one), np.std(other)) > 1e-3)
    expected = scipy.stats.ttest_ind(other, one, equal_var=False).confidence_interval()
    found = change(one, other)
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high), rel=1e-6, abs=1e-6)


def test_shares_of_episodes_are_never_sure():
    """No seed fails under either reward: the interval has a width, and both groups' floors are in it."""
    found = change([1.0] * 5, [1.0] * 5, SUCCESS)
    assert found.low < 0.0 < found.high
    assert found.spread == 0.0


@pytest.mark.parametrize("seeds", [1, 2])
def test_few_pairs_have_no_interval(seeds):
    """The difference stands alone."""
    found = change([0.0] * seeds, [1.0] * seeds)
    assert (found.difference, found.low, found.high) == (1.0, None, None)


# Tests


@given(st.lists(st.tuples(NUMBER, NUMBER), min_size=2, max_size=8))
def test_p_value_is_that_of_swapped_names(pairs):
    """In how many ways to swap the names of the trainings the difference is as large."""
    one, other = zip(*pairs, strict=True)
    outcomes = swaps_of(range(len(pairs))).signs @ np.subtract(other, one) / len(pairs)
    found = change(one, other)
    assert found.p == p_of(outcomes)
    assert found.outcomes == pytest.approx(outcomes)


def test_one_pair_has_no_p_value():
    """Its names can be swapped in one way alone."""
    assert change([0.0], [1.0]).p is None


# Direction


@pytest.mark.parametrize(("measure", "up", "down"), [(SUCCESS, "better", "worse"), (DISTANCE, "worse", "better")])
def test_direction_follows_what_is_better(measure, up, down):
    """More success is better, more distance is worse; by a corrected p of 0.05 at most, as one may be of hundreds."""
    low, high = [0.0, 0.1] * 3, [0.9, 1.0, 0.8] * 2
    found = change(low, high, measure)
    assert [corrected(found, p).direction for p in (None, 0.05, 0.0501)] == [up, up, ""]
    assert found.p < 0.05
    assert found.direction == corrected(change(low, low, measure), 0.0).direction == ""
    assert corrected(change(high, low, measure)).direction == down


@given(VALUES, VALUES)
def test_swapping_the_rewards_turns_the_difference(baseline, proposed):
    """What is better becomes worse, the ends change sides, p stays."""
    count = min(len(baseline), len(proposed))
    one, other = (
        change(*sides) for sides in ((baseline[:count], proposed[:count]), (proposed[:count], baseline[:count]))
    )
    assert one.p == other.p
    if one.low is not None and one.high is not None:
        assert (other.low, other.high) == pytest.approx((-one.high, -one.low), abs=1e-12)
    assert {corrected(found, 0.01).direction for found in (one, other)} in ({""}, {"better", "worse"})


# Equivalence


def test_equivalence_takes_the_bound_and_known_ends():
    """90 %, so 5 % to each side; how far a failure lies has to be known."""
    rng = default_rng(2)
    one, other = rng.random(9), rng.random(9)
    found = change(one.tolist(), other.tolist(), SUCCESS)
    low, high = difference_bounds(Side([one], [SHARE]), Side([other], [SHARE]))
    for margin in np.linspace(0.1, 1.0, 40):
        assert is_within(found, margin) == (-margin < low and high < margin)
    assert not is_within(change(one.tolist(), other.tolist()), 100.0)


def test_seeds_that_never_fail_are_not_equivalent_at_once():
    """Twenty do not show it, since one in ten may fail; sixty do. Two never are, however wide the margin."""
    for seeds, told in ((5, False), (20, False), (60, True)):
        assert is_within(change([1.0] * seeds, [1.0] * seeds, SUCCESS), 0.05) == told
    for seeds in (1, 2):
        assert not is_within(change([0.5] * seeds, [0.5] * seeds, SUCCESS), 100.0)


def test_a_training_that_left_no_value_counts_at_the_end_that_is_worst():
    """As if it had failed; without known ends there is no interval."""
    lost, failed = (change([0.2, 0.3, 0.25, 0.2], [0.9, 0.95, 0.9, end], SUCCESS) for end in (None, 0.0))
    assert lost.low == pytest.approx(failed.low)
    assert lost.failed == failed.failed
    assert lost.can_decide
    assert change([0.2, 0.3, 0.25, 0.2], [0.9, 0.95, 0.9, None]).low is None


# JSON


@given(VALUES, VALUES, st.booleans())
def test_json_is_strict(baseline, proposed, is_share):
    """Plain data without NaN, whatever is missing; what is None is null."""
    count = min(len(baseline), len(proposed))
    measure = DISTANCE._replace(episodes=10 if is_share else None)
    shares = [[value and abs(value) / 10.0 for value in values[:count]] for values in (baseline, proposed)]
    data = json.loads(json.dumps(change(*shares, measure).to_json(), allow_nan=False))
    keys = """name title unit better manner episodes baseline proposed random seeds left_out difference low high p
    p_corrected result trainings interquartile_means probability_of_improvement failed reason"""
    assert set(data) == {*keys.split()}


# What a measure can be


def test_a_difference_stays_within_what_a_measure_can_be():
    """As it says, a share within one."""
    values = [-1.0, 0.0, 1.0], [1.0, 0.0, -1.0]
    free, bound = change(*values), change(*values, DISTANCE._replace(bounds=(-1.0, 1.0)))
    assert free.high > 2.2
    assert (bound.low, bound.high) == (-2.0, 2.0)
    assert bound.p == free.p
    share = change([0.0, 0.5, 1.0], [1.0, 0.5, 0.0], SUCCESS)
    assert (share.low, share.high) == (-1.0, 1.0)
