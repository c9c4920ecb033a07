"""Indices of four scored groups: each is that of a group made anew of the runs that are left."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.random import default_rng
from numpy.testing import assert_array_equal

from harness.eta import BB, BK, KB, KK, curve_of
from harness.eta.splits import scored_sums

PAIRS = (BB, BK, KB, KK)
KINDS = st.sampled_from(["accumulated", "per-step"])
SIZES = st.tuples(st.integers(2, 5), st.integers(2, 5))
SEEDS = st.integers(0, 1000)


def rewards_of(sizes, seed):
    """Of the baseline's runs and of the proposed ones, under both rewards."""
    rng = default_rng(seed)
    count = {"baseline": sizes[0], "proposed": sizes[1]}
    return {pair: list(rng.normal(size=(count[pair[1]], 12))) for pair in PAIRS}


def sums_of(curve):
    """I_N, I_P and their sum."""
    index = curve.index
    return [index.negative_sum, index.positive_sum, index.negative_sum + index.positive_sum]


def found_of(sizes, seed, kind, paired=False):
    """Of all three sums."""
    curves = {pair: curve_of(runs, kind) for pair, runs in rewards_of(sizes, seed).items()}  # type: ignore[misc]
    return scored_sums(curves, paired)


@given(SIZES, SEEDS, KINDS)
def test_sums_are_those_of_the_runs(sizes, seed, kind):
    """With all, without each, and of each alone: a curve of those runs says the same."""
    found = found_of(sizes, seed, kind)
    for pair, runs in rewards_of(sizes, seed).items():
        whole = sums_of(curve_of(runs, kind))
        without = [sums_of(curve_of(runs[:out] + runs[out + 1 :], kind)) for out in range(len(runs))]
        each = [sums_of(curve_of([run], kind)) for run in runs]
        for which, sums in enumerate(found):
            assert sums.value(pair) == pytest.approx(whole[which], abs=1e-9)
            assert sums.without[pair] == pytest.approx(np.array(without)[:, which], abs=1e-9)
            assert sums.each[pair] == pytest.approx(np.array(each)[:, which], abs=1e-9)


def test_single_run_leaves_nothing_without_it():
    """A value, and no entry."""
    sums = found_of((1, 1), 0, "accumulated", paired=True)[0]
    assert [len(sums.without[pair]) for pair in PAIRS] == [0, 0, 0, 0]
    assert [len(sums.each[pair]) for pair in PAIRS] == [1, 1, 1, 1]


def test_pairs_are_left_out_together():
    """One entry, in which both runs of a seed are missing."""
    sums = found_of((4, 4), 0, "accumulated", paired=True)[0]
    (left_out,) = sums.left_out
    for pair in PAIRS:
        assert_array_equal(left_out[pair], sums.without[pair])


def test_seeds_without_pairs_are_left_out_apart():
    """First those of the baseline's training, whoever scores it; then those of the proposed one."""
    sums = found_of((3, 5), 0, "accumulated")[0]
    without_baseline, without_proposed = sums.left_out
    for pair in PAIRS:
        changed, kept = without_baseline[pair], without_proposed[pair]
        if pair[1] == "proposed":
            changed, kept = kept, changed
        assert_array_equal(changed, sums.without[pair])
        assert_array_equal(kept, np.full(5 if pair[1] == "baseline" else 3, sums.value(pair)))


@given(SEEDS)
def test_geometric_means_are_of_the_sizes(seed):
    """Of each training's runs under its own reward, whatever the sign; written out as a root of a product."""
    sums = found_of((3, 4), seed, "accumulated")[2]
    whole, (without_baseline, without_proposed) = sums.geometric()
    for pair in (BB, KK):
        sizes = np.abs(sums.each[pair])
        assert whole[pair] == pytest.approx(np.prod(sizes) ** (1.0 / len(sizes)))
        left_out = without_baseline if pair[1] == "baseline" else without_proposed
        expected = [np.prod(np.delete(sizes, out)) ** (1.0 / (len(sizes) - 1)) for out in range(len(sizes))]
        assert left_out[pair] == pytest.approx(expected)
