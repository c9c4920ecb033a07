"""Intervals over seeds: reproducible, paired, honest about what is not defined."""

import random
from collections.abc import Callable

import numpy as np
import pytest

from harness.index import index_of, mean_curve
from harness.statistics import FEW_SEEDS, compare_runs

MakeRuns = Callable[..., np.ndarray]


@pytest.fixture
def make_runs() -> MakeRuns:
    """Curves that fall below zero and rise again, each a little different, (seeds, steps)."""
    rng = np.random.default_rng(105)

    def make(seeds: int, steps: int = 60, scale: float = 1.0) -> np.ndarray:
        x = np.linspace(0.0, 1.0, steps)
        depth = 10.0 + rng.normal(size=(seeds, 1))
        height = 30.0 + 3.0 * rng.normal(size=(seeds, 1))
        return scale * (-depth * np.sin(np.pi * x) * (x < 0.5) + height * (x - 0.4) * (x >= 0.5))

    return make


def _slow_interval(baseline: np.ndarray, proposed: np.ndarray, sign: int) -> list[float]:
    """A paired bootstrap with loops and Python's own random numbers."""
    draws, ratios = random.Random(1), []
    for _ in range(2000):
        rows = draws.choices(range(len(baseline)), k=len(baseline))
        sums = [sum(v for v in runs[rows].mean(axis=0) if v * sign > 0) for runs in (proposed, baseline)]
        ratios.append(sums[0] / sums[1])
    ratios.sort()
    return [ratios[49], ratios[1949]]


def test_same_runs_give_the_same_interval(make_runs: MakeRuns):
    """Nothing is drawn from a global generator: bit for bit the same, whatever was drawn before."""
    baseline, proposed = make_runs(6), make_runs(6, scale=2.0)
    first = compare_runs(baseline, proposed)
    np.random.default_rng().random(100)
    assert compare_runs(baseline, proposed) == first


def test_indices_are_those_of_the_mean_curves(make_runs: MakeRuns):
    """The comparison holds both groups' indices, and the ratios of these."""
    baseline, proposed = make_runs(3), make_runs(3, steps=50, scale=2.0)
    compared = compare_runs(baseline, proposed)
    assert compared.baseline == index_of(mean_curve(baseline))
    assert compared.proposed == index_of(mean_curve(proposed))
    assert compared.eta_n.value == compared.proposed.I_N / compared.baseline.I_N
    assert compared.eta_p.value == compared.proposed.I_P / compared.baseline.I_P


def test_seeds_are_paired(make_runs: MakeRuns):
    """A group against twice itself differs by exactly 2 under every draw of seeds, so the interval has no width."""
    baseline = make_runs(6)
    compared = compare_runs(baseline, 2.0 * baseline)
    for ratio in (compared.eta_n, compared.eta_p):
        assert (ratio.low, ratio.high) == pytest.approx((2.0, 2.0), rel=1e-9)


def test_pairs_matter(make_runs: MakeRuns):
    """With the seeds of one group in another order the pairs are others, and the interval is wider than none."""
    baseline = make_runs(6)
    ratio = compare_runs(baseline, 2.0 * baseline[::-1]).eta_p
    assert ratio.high - ratio.low > 0.01


def test_order_of_the_pairs_hardly_matters(make_runs: MakeRuns):
    """Shuffling the pairs moves the interval by no more than the draws do."""
    baseline, proposed = make_runs(8), make_runs(8, scale=2.0)
    order = np.random.default_rng(7).permutation(8)
    one, other = compare_runs(baseline, proposed).eta_p, compare_runs(baseline[order], proposed[order]).eta_p
    assert (one.low, one.high) == pytest.approx((other.low, other.high), rel=0.03)


def test_interval_agrees_with_a_slow_bootstrap(make_runs: MakeRuns):
    """Another bootstrap, in loops and with other random numbers, ends at the same places."""
    baseline, proposed = make_runs(8), make_runs(8, scale=1.5)
    compared = compare_runs(baseline, proposed)
    negative, positive = (_slow_interval(baseline, proposed, sign) for sign in (-1, 1))
    assert [compared.eta_n.low, compared.eta_n.high] == pytest.approx(negative, rel=0.02)
    assert [compared.eta_p.low, compared.eta_p.high] == pytest.approx(positive, rel=0.02)


def test_interval_contains_the_true_ratio_usually(make_runs: MakeRuns):
    """Drawn 60 times with 10 seeds, the true ratio of 2 lies inside at least 48 times."""
    intervals = [compare_runs(make_runs(10), make_runs(10, scale=2.0)).eta_p for _ in range(60)]
    assert sum(ratio.low <= 2.0 <= ratio.high for ratio in intervals) >= 48


def test_interval_is_around_the_value(make_runs: MakeRuns):
    """The value lies between the ends."""
    compared = compare_runs(make_runs(5), make_runs(5))
    for ratio in (compared.eta_n, compared.eta_p):
        assert ratio.low < ratio.value < ratio.high


def test_groups_may_differ_in_length(make_runs: MakeRuns):
    """Each group's curve is as long as its own shortest run."""
    compared = compare_runs(make_runs(4, steps=60), make_runs(4, steps=40))
    assert (compared.baseline.steps, compared.proposed.steps) == (60, 40)
    assert compared.eta_p.low is not None


def test_more_steps_than_fit_into_memory_at_once():
    """The resamples are taken in parts, the last one shorter than the others: the mean of all is the curve's."""
    runs = np.vstack([np.full(10, -1.0), np.full(10, -3.0)])
    ratio = compare_runs(np.full((2, 10), -1.0), runs).eta_n
    assert (ratio.value, ratio.low, ratio.high) == (2.0, 1.0, 3.0)


def test_one_seed_has_a_value_and_no_interval(make_runs: MakeRuns):
    """Nothing can be said about the spread of one run."""
    runs = make_runs(1)
    ratio = compare_runs(runs, 2.0 * runs).eta_n
    assert ratio.value == pytest.approx(2.0, rel=1e-2)
    assert (ratio.low, ratio.high, ratio.note) == (None, None, "one seed: no interval")


def test_few_seeds_carry_a_note(make_runs: MakeRuns):
    """An interval over few seeds is given, and called rough."""
    few, enough = (compare_runs(*[make_runs(seeds)] * 2).eta_p for seeds in (FEW_SEEDS - 1, FEW_SEEDS))
    assert few.note == "4 seeds: the interval is rough below 5"
    assert few.low is not None
    assert enough.note == ""


def test_baseline_that_is_never_negative_has_no_eta_n(make_runs: MakeRuns):
    """The reason stands in the note, and eta_P is not touched by it."""
    compared = compare_runs(np.ones((5, 10)), make_runs(5))
    assert (compared.eta_n.value, compared.eta_n.low, compared.eta_n.high) == (None, None, None)
    assert compared.eta_n.note.startswith("I_N of the baseline is 0")
    assert compared.eta_p.low is not None


def test_denominator_that_vanishes_in_some_draws_leaves_no_interval(make_runs: MakeRuns):
    """With one negative run of five, many draws have no I_N: the value stands, the interval does not, never inf."""
    baseline = np.ones((5, 10))
    baseline[0] = -9.0
    ratio = compare_runs(baseline, make_runs(5)).eta_n
    assert ratio.value is not None
    assert (ratio.low, ratio.high) == (None, None)
    assert ratio.note.startswith("no interval: I_N of the baseline is 0 in ")
