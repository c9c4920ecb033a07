"""I_N, I_P and their ratios, as the published table was computed."""

from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from harness.index import Index, Ratio, accumulated_reward, eta_n, eta_p, index_of, mean_curve, stack_runs

REWARDS = st.lists(
    st.lists(st.floats(-10.0, 10.0).map(lambda value: round(value, 3)), min_size=1, max_size=30), min_size=1, max_size=6
)
# A power of two scales floats without rounding.
SCALES = st.sampled_from([2.0, 4.0, 1024.0])


def _index(rewards: list[Any]) -> Index:
    return index_of(mean_curve(stack_runs([np.array(reward, float) for reward in rewards])))


def _slow_index(rewards: list[list[float]]) -> tuple[Any, ...]:
    """The four steps of the published computation, written without numpy."""
    steps = min(len(reward) for reward in rewards)
    sums = []
    for reward in rewards:
        total, sums_of_run = 0.0, []
        for value in reward:
            total += value
            sums_of_run.append(total)
        sums.append(sums_of_run[:steps])
    curve = [sum(column) / len(column) for column in zip(*sums, strict=True)]
    first = next((step for step, value in enumerate(curve) if value < 0), None)
    crossover = None
    if first is not None:
        crossover = next((step for step in range(first + 1, steps) if curve[step] >= 0), None)
    return first, crossover, steps, sum(v for v in curve if v < 0), sum(v for v in curve if v > 0), curve


def test_reward_is_accumulated_over_the_run():
    """The running sum, the first reward included."""
    assert accumulated_reward(np.array([0.0, 1.0, -3.0, 0.5])).tolist() == [0.0, 1.0, -2.0, -1.5]


def test_runs_are_cut_to_the_shortest():
    """A group is as long as its shortest run."""
    stacked = stack_runs([np.array([1.0, 1.0, 1.0]), np.array([2.0, -1.0])])
    assert stacked.tolist() == [[1.0, 2.0], [2.0, 1.0]]


def test_curve_is_the_mean_at_each_step():
    """Over runs, not over steps."""
    assert mean_curve(np.array([[1.0, 2.0], [2.0, 0.0]])).tolist() == [1.5, 1.0]


CURVES = {
    "positive, negative, positive": ([1, -1, -2, 3, 4], Index(1, 3, 5, -3.0, 8.0)),
    "zero is not negative": ([0, -1, 0, 5], Index(1, 2, 4, -1.0, 5.0)),
    "negative again": ([-1, 2, -3, 4], Index(0, 1, 4, -4.0, 6.0)),
    "never negative": ([0, 1, 2], Index(None, None, 3, 0.0, 3.0)),
    "never back": ([1, -1, -2], Index(1, None, 3, -3.0, 1.0)),
    "negative at the end": ([1, 2, -1], Index(2, None, 3, -1.0, 3.0)),
    "always negative": ([-1, -2], Index(0, None, 2, -3.0, 0.0)),
    "one step": ([-2], Index(0, None, 1, -2.0, 0.0)),
    "flat": ([0, 0], Index(None, None, 2, 0.0, 0.0)),
    "rounded": ([-0.16, -0.1, 0.33, 0.1], Index(0, 2, 4, -0.3, 0.4)),
    "rounded to nothing": ([-0.01, 0.01], Index(0, 1, 2, 0.0, 0.0)),
}


@pytest.mark.parametrize(("curve", "index"), CURVES.values(), ids=CURVES)
def test_index_of_a_curve(curve: list[float], index: Index):
    """First negative step, first step after it that is not, sums of all negative and all positive values."""
    assert index_of(np.array(curve, float)) == index


def test_sum_that_rounds_to_zero_has_no_sign():
    """Minus zero would be printed."""
    assert str(index_of(np.array([-0.01, 0.0])).I_N) == "0.0"


def test_published_table():
    """The published indices give the published ratios, to the eight decimals in print."""
    baseline = Index(40, 13_635, 54_920, -5_205_975.7, 1.52978159e8)
    proposed = Index(59, 6_529, 53_689, -1_102_275.0, 3.96901875e8)
    assert eta_n(proposed, baseline).value == pytest.approx(0.21173264, abs=5e-9)
    assert eta_p(proposed, baseline).value == pytest.approx(2.59450027, abs=5e-9)


def test_ratio_without_a_denominator_is_none_with_the_reason():
    """Never infinite, never NaN: what is 0 is said."""
    nothing, something = Index(None, None, 3, 0.0, 0.0), Index(1, 2, 3, -1.0, 1.0)
    for proposed in (nothing, something):
        note = "I_N of the baseline is 0: its mean accumulated reward is never negative"
        assert eta_n(proposed, nothing) == Ratio(None, note=note)
        note = "I_P of the baseline is 0: its mean accumulated reward is never positive"
        assert eta_p(proposed, nothing) == Ratio(None, note=note)


def test_ratio_of_nothing_to_something_is_zero():
    """A proposed reward whose curve is never negative has eta_N 0, without a sign."""
    nothing, something = Index(None, None, 3, 0.0, 0.0), Index(1, 2, 3, -1.0, 1.0)
    assert str(eta_n(nothing, something).value) == "0.0"
    assert eta_p(nothing, something).value == 0.0


@given(REWARDS)
def test_index_agrees_with_a_plain_computation(rewards: list[list[float]]):
    """The published steps, written out in loops, give the same index."""
    first, crossover, steps, negative, positive, curve = _slow_index(rewards)
    assume(all(value == 0 or abs(value) > 1e-9 for value in curve))  # sums in another order may differ in sign there
    index = _index(rewards)
    assert (index.first_negative, index.crossover, index.steps) == (first, crossover, steps)
    assert pytest.approx(negative, abs=0.0500001) == index.I_N
    assert pytest.approx(positive, abs=0.0500001) == index.I_P


@given(REWARDS, st.randoms())
def test_order_of_runs_does_not_matter(rewards: list[list[float]], random: Any):
    """Permuting the runs of a group changes nothing but the last bits."""
    shuffled = list(rewards)
    random.shuffle(shuffled)
    curves = [mean_curve(stack_runs([np.array(reward) for reward in group])) for group in (rewards, shuffled)]
    np.testing.assert_allclose(curves[0], curves[1], atol=1e-12)
    assume((np.abs(curves[0]) > 1e-9).all())
    one, other = _index(rewards), _index(shuffled)
    assert (one.first_negative, one.crossover, one.steps) == (other.first_negative, other.crossover, other.steps)
    assert pytest.approx((other.I_N, other.I_P), abs=0.1000001) == (one.I_N, one.I_P)


@given(REWARDS, SCALES)
def test_scaling_a_group_scales_its_sums(rewards: list[list[float]], scale: float):
    """The ruler shows in I_N and I_P, up to their rounding, and nowhere else."""
    one, scaled = _index(rewards), _index([[value * scale for value in reward] for reward in rewards])
    assert (one.first_negative, one.crossover, one.steps) == (scaled.first_negative, scaled.crossover, scaled.steps)
    assert pytest.approx((one.I_N * scale, one.I_P * scale), abs=0.0500001 * (scale + 1)) == (scaled.I_N, scaled.I_P)


@given(arrays(float, st.integers(1, 50), elements=st.floats(-1e6, 1e6)))
def test_index_bounds(curve: np.ndarray):
    """I_N is at most 0, I_P at least 0, the crossover comes after the first negative step."""
    index = index_of(curve)
    assert index.I_N <= 0.0 <= index.I_P
    assert index.crossover is None or 0 <= index.first_negative < index.crossover < index.steps
    assert (index.first_negative is None) == bool((curve >= 0.0).all())
