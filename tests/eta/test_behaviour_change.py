"""The change of one measure of behaviour: means, the interval of their difference, its direction."""

import json

import numpy as np
import pytest
import scipy.stats
from hypothesis import given
from hypothesis import strategies as st

from harness.eta.behaviour_change import Change, change_of
from harness.eta.statistics import FEW_SEEDS

Values = list[float | None]
VALUES = st.lists(st.none() | st.floats(-10.0, 10.0), min_size=1, max_size=8)


def success(baseline: Values, proposed: Values, random: Values = ()) -> Change:
    """A metric of which more is better."""
    return change_of("success_rate", "", "higher", baseline, proposed, list(random))


def distance(baseline: Values, proposed: Values) -> Change:
    """A metric of which less is better."""
    return change_of("final_distance", "m", "lower", baseline, proposed, [])


def test_means_over_seeds():
    """Under the baseline, under the proposed reward, and of random actions under both."""
    change = success([0.25, 0.75], [1.0, 0.5], [0.0, 0.0, 0.0, 0.25])
    assert (change.baseline, change.proposed, change.random) == (0.5, 0.75, 0.0625)


def test_metric_that_is_not_defined_is_none():
    """Steps to a target that is never reached: no number, rather than NaN."""
    change = distance([None, None], [0.5, None])
    assert (change.baseline, change.proposed, change.random) == (None, 0.5, None)
    assert (change.seeds, change.low, change.high, change.p, change.direction) == (0, None, None, None, "")


def test_difference_is_taken_of_seeds_with_both_values():
    """A seed without a value under one reward is no pair, and its other value still counts in the mean."""
    change = distance([1.0, None, 3.0], [2.0, 9.0, 4.0])
    assert change.seeds == 2
    assert (change.low, change.high) == (1.0, 1.0)
    assert change.proposed == 5.0


def test_seeds_are_paired():
    """What is added to every seed has no spread, however much the seeds differ."""
    change = success([0.0, 0.25, 0.5, 0.75], [0.25, 0.5, 0.75, 1.0])
    assert (change.low, change.high) == (0.25, 0.25)


def test_one_pair_has_no_interval():
    """Nothing can be said about its spread."""
    change = success([0.0], [1.0])
    assert (change.seeds, change.low, change.high, change.p, change.direction) == (1, None, None, None, "")


def test_interval_agrees_with_scipy():
    """The paired percentile bootstrap of the mean difference."""
    rng = np.random.default_rng(0)
    baseline, proposed = rng.uniform(size=12), rng.uniform(size=12) + 0.3
    interval = scipy.stats.bootstrap(
        (proposed - baseline,), np.mean, method="percentile", n_resamples=20_000, rng=np.random.default_rng(1)
    ).confidence_interval
    change = success(list(baseline), list(proposed))
    assert (change.low, change.high) == pytest.approx((interval.low, interval.high), abs=0.02)


@pytest.mark.parametrize(
    ("baseline", "proposed", "higher", "lower"),
    [
        ([0.0, 0.1, 0.2], [0.9, 1.0, 0.8], "better", "worse"),
        ([0.9, 1.0, 0.8], [0.0, 0.1, 0.2], "worse", "better"),
        ([0.0, 1.0, 0.5], [1.0, 0.0, 0.5], "", ""),
        ([0.5, 0.5, 0.5], [0.5, 0.5, 0.5], "", ""),
    ],
)
def test_direction(baseline: Values, proposed: Values, higher: str, lower: str):
    """Better or worse as the metric has it, where the interval does not hold 0."""
    assert success(baseline, proposed).direction == higher
    assert distance(baseline, proposed).direction == lower


@given(VALUES, VALUES)
def test_swapping_the_rewards_turns_the_direction(baseline: Values, proposed: Values):
    """What is better one way is worse the other way."""
    count = min(len(baseline), len(proposed))
    one, other = success(baseline[:count], proposed[:count]), success(proposed[:count], baseline[:count])
    assert {one.direction, other.direction} in ({""}, {"better", "worse"})


@given(VALUES, VALUES)
def test_json_is_strict(baseline: Values, proposed: Values):
    """Plain data without NaN, whatever is missing; what is None is null."""
    count = min(len(baseline), len(proposed))
    change = success(baseline[:count], proposed[:count])
    data = json.loads(json.dumps(change.to_json(), allow_nan=False))
    keys = {"name", "unit", "better", "baseline", "proposed", "random", "seeds", "low", "high", "p"}
    assert set(data) == keys
    assert change == Change(**data)


def test_direction_is_sure_with_enough_seeds():
    """Below FEW_SEEDS a direction is given, and is not sure."""
    for seeds, sure in ((FEW_SEEDS - 1, False), (FEW_SEEDS, True)):
        change = success([0.0] * seeds, [1.0] * seeds)
        assert change.direction == "better"
        assert change.sure == sure


def test_no_direction_is_never_sure():
    """However many seeds there are."""
    assert not success([0.5] * 20, [0.5] * 20).sure


def test_p_value_is_that_of_no_difference():
    """Small where every seed says the same, 1 where nothing differs."""
    assert success([0.0] * 6, [1.0, 0.9, 0.8] * 2).p < 0.01
    assert success([0.5] * 6, [0.5] * 6).p == 1.0
