"""eta = ruler x behaviour: what must hold exactly, what is not defined, and where there is no interval."""

import itertools
import json

import numpy as np
import pytest
import scipy.stats
from hypothesis import given, settings, strategies as st
from hypothesis.extra.numpy import arrays
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.eta import (
    BB,
    BK,
    KB,
    KK,
    Estimate,
    curve_of,
    decompose,
    p_of,
    swaps_of,
)
from harness.eta.decomposition import split_halves

KINDS = ("accumulated", "per-step")
STEP = st.one_of(st.sampled_from([0.0, 0.1, -0.1, 1.0, -1.0]), st.floats(-10.0, 10.0).map(lambda v: round(v, 6)))
POWERS = st.integers(-30, 30).map(lambda exponent: 2.0**exponent)
FEWER = settings(max_examples=50)
"""Each example is decomposed once or twice, with all ways of swapping its runs."""


def groups(most=6):
    """Rewards of a group's runs, (runs, steps)."""
    shapes = st.tuples(st.integers(1, most), st.integers(1, 12))
    return shapes.flatmap(lambda shape: arrays(float, shape, elements=STEP))


def four(most=5):
    """Two trainings under two rewards: BB, BK, KB, KK, (runs, steps) each, whatever the rewards."""
    shapes = st.tuples(*(st.tuples(st.integers(1, most), st.integers(1, 8)) for _ in "BK"))
    return shapes.flatmap(
        lambda both: st.tuples(*(arrays(float, both[who], elements=STEP) for who in (0, 1, 0, 1))).map(list)
    )


def curves_of(bb, bk, kb, kk, kind="accumulated"):
    """The four scored groups."""
    named = {BB: bb, BK: bk, KB: kb, KK: kk}
    return {pair: curve_of(list(np.asarray(runs, float)), kind) for pair, runs in named.items()}


def values_of(split):
    """Eta, both parts, then both paths."""
    parts = [split.eta, split.ruler, split.behaviour, *(part for path in split.paths for part in path)]
    return [part.value for part in parts]


def ratios_of(split):
    """All of them."""
    single = [split.eta, split.per_seed, split.ruler, split.behaviour, split.interaction, split.noise]
    return [*single, *(part for path in split.paths for part in path)]


def splits_of(found):
    """Of eta_N and of eta_P."""
    return [found.negative, found.positive]


def eta_of(baseline, proposed, paired=True):
    """Both etas, nothing scored again."""
    return decompose({BB: curve_of(list(baseline)), KK: curve_of(list(proposed))}, paired=paired)


def ends(ratio):
    """Of the interval."""
    return [ratio.low, ratio.high]


def about(value, rel=1e-9):
    """The same but for rounding; None is None."""
    return value if value is None else pytest.approx(value, rel=rel)


def dip_and_climb(seeds, seed=105, steps=60, noise=1.0):
    """Rewards whose sums fall below zero and rise again, each run a little different, (seeds, steps)."""
    rng = default_rng(seed)
    x = np.linspace(0.0, 1.0, steps)
    depth = 10.0 + noise * rng.normal(size=(seeds, 1))
    height = 30.0 + 3.0 * noise * rng.normal(size=(seeds, 1))
    return np.diff(-depth * np.sin(np.pi * x) * (x < 0.5) + height * (x - 0.4) * (x >= 0.5), axis=1, prepend=0.0)


# What holds exactly


@FEWER
@given(groups(), POWERS, st.sampled_from(KINDS))
def test_scaled_baseline_is_all_ruler(runs, scale, kind):
    """A reward that is c times the baseline, on the same runs: ruler c and behaviour 1 on both paths."""
    for split in splits_of(decompose(curves_of(runs, runs, scale * runs, scale * runs, kind))):
        one_path = [scale, 1.0]
        expected = [scale, *one_path, *one_path, *one_path]
        assert values_of(split) in ([about(value, 1e-12) for value in expected], [None] * 7)
        for part in (split.eta, split.ruler, split.behaviour, split.interaction):
            assert part.low is None or part.low == about(part.value) == about(part.high)


@FEWER
@given(groups(), st.sampled_from(KINDS))
def test_reward_against_itself_is_one(runs, kind):
    """A/A with the same runs: eta, rulers and behaviours are 1, no way of swapping tells them apart."""
    found = decompose(curves_of(runs, runs, runs, runs, kind))
    for split in splits_of(found):
        assert values_of(split) in ([1.0] * 7, [None] * 7)
        assert {part.low for part in ratios_of(split) if part is not split.noise} <= {1.0, None}
        assert split.p in (1.0, None)
        assert split.opposition == ""
    assert (found.total.change.value, found.total.ruler.value, found.total.behaviour.value) == (0.0, 0.0, 0.0)


@FEWER
@given(four(), st.sampled_from(KINDS))
def test_both_paths_multiply_to_eta(scored, kind):
    """Ruler x behaviour = eta along either path, to the last bits; what is shown are the paths' geometric means."""
    for split in splits_of(decompose(curves_of(*scored, kind))):
        for ruler, behaviour in split.paths:
            if split.eta.value is not None and ruler.value is not None and behaviour.value is not None:
                assert ruler.value * behaviour.value == pytest.approx(split.eta.value, rel=1e-12, abs=0.0)
        if split.ruler.value is None or split.behaviour.value is None:
            continue
        (r1, b1), (r2, b2) = ((path.ruler.value, path.behaviour.value) for path in split.paths)
        parts = [(r1 * r2) ** 0.5, (b1 * b2) ** 0.5, r1 / r2]
        assert [split.ruler.value, split.behaviour.value, split.interaction.value] == pytest.approx(parts, rel=1e-9)
        assert split.ruler.value * split.behaviour.value == pytest.approx(split.eta.value, rel=1e-9)


@FEWER
@given(four())
def test_parts_do_not_know_which_reward_is_the_baseline(scored):
    """Swapped, parts are 1 over what they were, intervals too, and those of the sum change signs; interactions stay."""
    bb, bk, kb, kk = scored
    one, other = decompose(curves_of(bb, bk, kb, kk)), decompose(curves_of(kk, kb, bk, bb))
    for split, swapped in zip(splits_of(one), splits_of(other), strict=True):
        for name in ("eta", "ruler", "behaviour"):
            part, inverse = getattr(split, name), getattr(swapped, name)
            if part.value and inverse.value:
                assert part.value * inverse.value == pytest.approx(1.0, rel=1e-9)
            if part.low and inverse.high:
                assert part.low * inverse.high == pytest.approx(1.0, rel=1e-6)
        if split.interaction.value and swapped.interaction.value:
            assert split.interaction.value == pytest.approx(swapped.interaction.value, rel=1e-9)
        if len(bb) == len(bk):  # groups of unlike size are compared in ways that are drawn
            assert split.p == swapped.p
    for name in ("change", "ruler", "behaviour"):
        part, opposite = getattr(one.total, name), getattr(other.total, name)
        assert part.value == pytest.approx(-opposite.value, abs=1e-9)
        if part.low is not None:
            assert (part.low, part.high) == pytest.approx((-opposite.high, -opposite.low), rel=1e-6, abs=1e-6)


def test_order_of_the_pairs_changes_nothing():
    """Seeds are a set: their pairs shuffled, every value and end stays, and p."""
    baseline, proposed = dip_and_climb(8), 2.0 * dip_and_climb(8, seed=3)
    order = default_rng(7).permutation(8)
    one, other = eta_of(baseline, proposed).positive, eta_of(baseline[order], proposed[order]).positive
    assert [one.per_seed.value, *ends(one.eta)] == [about(it) for it in (other.per_seed.value, *ends(other.eta))]
    assert one.p == other.p


def test_parts_of_a_worked_example():
    """By hand: I_P is 2, 4, 6 and 24 for S_B(tau_B), S_B(tau_K), S_K(tau_B) and S_K(tau_K).

    Of the sum, from 2 to 24, the ruler adds 20 on the proposed runs and 4 on the baseline's, 12 on average.
    """
    found = decompose(curves_of([[2.0]], [[4.0]], [[6.0]], [[24.0]]))
    split, total = found.positive, found.total
    assert values_of(split) == [12.0, about(18.0**0.5), about(8.0**0.5), 6.0, 2.0, 3.0, 4.0]
    assert (split.interaction.value, split.per_seed.value) == (about(2.0), about(12.0))
    assert (total.change.value, total.ruler.value, total.behaviour.value) == (22.0, 12.0, 10.0)


# The sum, split by differences


@FEWER
@given(four(), st.sampled_from(KINDS))
def test_sum_splits_into_ruler_and_behaviour(scored, kind):
    """They add up to the change of I_N + I_P, which is always defined."""
    found = decompose(curves_of(*scored, kind))
    total = found.total
    change = sum((found.proposed.negative_sum, found.proposed.positive_sum, -found.baseline.negative_sum))
    assert total.change.value == pytest.approx(change - found.baseline.positive_sum, abs=1e-9)
    assert total.ruler.value + total.behaviour.value == pytest.approx(total.change.value, abs=1e-9)


def test_sum_has_the_interval_of_the_paired_t_test():
    """The sum of a mean curve is the mean of the runs' sums: scipy knows its interval."""
    baseline, proposed = dip_and_climb(7), 1.5 * dip_and_climb(7, seed=1)
    sums = [np.cumsum(runs, axis=1).sum(axis=1) for runs in (proposed, baseline)]
    expected = scipy.stats.ttest_rel(*sums).confidence_interval()
    change = eta_of(baseline, proposed).total.change
    assert (change.low, change.high) == pytest.approx((expected.low, expected.high), rel=1e-6)
    assert change.seeds == 7


def test_sum_of_two_seeds_has_no_interval():
    """Its parts stand alone, with the reason."""
    total = decompose(curves_of(*[dip_and_climb(2)] * 4)).total
    for part in (total.change, total.ruler, total.behaviour):
        assert (part.low, part.note) == (None, "2 seeds: no interval below 3 seeds")


# Nothing that is no number


@FEWER
@given(four(), st.sampled_from(KINDS), st.booleans(), st.sampled_from([1.0, 1e-300, 1e100]))
def test_json_is_strict(scored, kind, paired, scale):
    """Neither infinity nor NaN gets into the JSON, also where sums are zero, tiny or huge; each None has a reason."""
    bb, bk, kb, kk = scored
    found = decompose(curves_of(scale * bb, bk, kb, kk, kind), paired=paired)
    assert json.loads(json.dumps(found.to_json(), allow_nan=False)) == found.to_json()
    for split in splits_of(found):
        for part in ratios_of(split):
            assert part.note or None not in (part.value, part.low, part.high)


def test_corrected_p_values_are_put_beside_the_others():
    """Of each eta its own, nothing else changes."""
    found = eta_of(dip_and_climb(4), dip_and_climb(4, seed=1))
    marked = found.with_corrected(0.3, 0.7)
    assert (marked.negative.corrected, marked.positive.corrected) == (0.3, 0.7)
    assert (marked.negative.p, marked.positive.p) == (found.negative.p, found.positive.p)
    assert marked.to_json()["eta_P"]["p_corrected"] == 0.7


# Zero and next to zero


WITHOUT = {
    "I_N": ([[1.0, 1.0]], "negative", "its mean accumulated reward is never negative"),
    "I_P": ([[-1.0, -1.0]], "positive", "its mean accumulated reward is never positive"),
}


@pytest.mark.parametrize(("name", "given_runs"), list(WITHOUT.items()))
def test_zero_denominator_is_none_with_the_reason(name, given_runs):
    """A ratio to 0 has no value, and its note says whose index is 0, and why."""
    runs, which, why = given_runs
    other = [[-1.0, 2.0]]
    split = getattr(decompose(curves_of(runs, other, other, other)), which)
    nothing = Estimate(None, notes=(f"{name} of the baseline is 0: {why}",))
    first, second = split.paths
    assert split.eta == split.ruler == split.behaviour == split.interaction == nothing
    assert first.behaviour == second.ruler == nothing
    assert first.ruler.value == second.behaviour.value == 1.0


@pytest.mark.parametrize(
    ("pair", "owner"),
    [
        (BK, "the proposed runs under the baseline reward"),
        (KB, "the baseline runs under the proposed reward"),
    ],
)
def test_zero_of_a_scored_group_leaves_eta_and_the_other_path(pair, owner):
    """The shown parts are of both paths: they are gone."""
    runs = {scored: [[-1.0, 2.0]] for scored in (BB, BK, KB, KK)}
    runs[pair] = [[-1.0, 0.0]]
    split = decompose(curves_of(*runs.values())).positive
    kept = split.paths[1] if pair == BK else split.paths[0]
    assert (kept.ruler.value, kept.behaviour.value, split.eta.value) == (1.0, 1.0, 1.0)
    for part in (split.ruler, split.behaviour, split.interaction):
        assert part.value is None
        assert part.note.startswith(f"I_P of {owner} is 0: ") or "not above 0" in part.note


def test_eta_of_something_to_nothing_is_zero():
    """A proposed reward whose curve is never negative has eta_N 0, without a sign, and no interval by logarithms."""
    eta = eta_of(dip_and_climb(5), np.ones((5, 4))).eta_n
    assert str(eta.value) == "0.0"
    assert ends(eta) == [None, None]
    assert eta.notes == ("no interval: the ratio is not above 0",)
    assert eta.near_zero is not None


NEVER, ONE = np.ones((5, 60)), np.ones((5, 10))
NEVER[1:], ONE[0] = dip_and_climb(5)[1:], -9.0
SIGNED = [[-1.0, 0.0, value] for value in (2.0, 2.0, -1.0)]
SHORT = eta_of(dip_and_climb(9), dip_and_climb(2, seed=2)), eta_of(dip_and_climb(2, seed=2), dip_and_climb(9))
TINY = decompose(curves_of([[1e-310]], [[1.0]], [[1.0]], [[1e10]])).positive
REASONS = {
    "a ratio too large for a number": (
        TINY.eta,
        "I_P of the baseline is as good as 0: the ratio is no number any more",
    ),
    "of seeds too": (TINY.per_seed, "the ratio is too large for a number"),
    "one run of three is next to nothing, and so the ratio without the others is": (
        eta_of(np.array([[1e-250], [1e-250], [1.0]]), np.ones((3, 1))).eta_p,
        "no interval: its upper end is too large for a number",
    ),
    "one of five runs is never negative": (
        eta_of(dip_and_climb(5), NEVER).negative.per_seed,
        "I_N of 1 of the 5 runs of the proposed reward is 0 by itself",
    ),
    "per step I_P of seeds may be below zero": (
        decompose(curves_of(*[SIGNED] * 4, "per-step")).positive.per_seed,
        "I_P of single runs has either sign",
    ),
    "without the one negative run of five there is no I_N": (
        eta_of(ONE, dip_and_climb(5)).eta_n,
        "no interval: without one of the seeds I_N of a group is 0 or changes its sign",
    ),
    "the smaller group decides": (SHORT[0].eta_p, "2 seeds: no interval below 3 seeds"),
    "whichever it is": (SHORT[1].eta_p, "2 seeds: no interval below 3 seeds"),
    "per step nothing is accumulated": (
        decompose(curves_of(*[[[1.0]]] * 4, "per-step")).eta_n,
        "I_N of the baseline is 0: its mean reward is never negative",
    ),
    "nor does it end above zero": (
        decompose(curves_of(*[[[-1.0, -1.0]]] * 4, "per-step")).eta_p,
        "I_P of the baseline is 0: its mean reward has nothing after a cross-over",
    ),
}


@pytest.mark.parametrize(("ratio", "note"), REASONS.values(), ids=REASONS)
def test_what_is_missing_has_its_reason(ratio, note):
    """A value that is there stays without its interval."""
    assert ratio.notes == (note,)
    assert ratio.low is ratio.high is None
    assert (ratio.value is None) == (not note.startswith(("no interval", "2 seeds")))


def test_paths_of_unlike_sign_have_no_mean():
    """Read per step an index may have either sign."""
    scored = curves_of([[-1.0, 0.0, 1.0]], [[-1.0, 0.0, -1.0]], [[-1.0, 0.0, 2.0]], [[-1.0, 0.0, 2.0]], "per-step")
    split = decompose(scored).positive
    assert [path.ruler.value for path in split.paths] == [-2.0, 2.0]
    note = "a part of a path is not above 0: the paths have no geometric mean"
    assert split.ruler == split.behaviour == Estimate(None, notes=(note,))


def test_index_near_zero_beside_the_other_trainings_says_so():
    """The proposed runs hardly pay under the baseline reward: the value stays, every ratio with that index is noted."""
    split = decompose(curves_of([[1000.0]], [[1.0]], [[46_000.0]], [[25_000.0]])).positive
    first, second = split.paths
    told = "I_P of the proposed runs under the baseline reward is near zero beside that of the baseline"
    for part in (*first, split.ruler, split.behaviour, split.interaction):
        assert part.near_zero == told
    assert first.ruler.value == 25_000.0
    assert split.eta.near_zero is second.ruler.near_zero is second.behaviour.near_zero is None


@pytest.mark.parametrize("scale", [1000.0, 0.001])
def test_other_units_are_not_near_zero(scale):
    """Indices under two rewards are not compared: a reward in millimetres makes nothing small."""
    runs = dip_and_climb(6)
    for split in splits_of(decompose(curves_of(runs, runs, scale * runs, scale * runs))):
        assert {part.near_zero for part in ratios_of(split)} == {None}


@pytest.mark.parametrize(("factor", "is_noted"), [(1.01, False), (0.99, True)])
def test_near_zero_begins_at_its_share(factor, is_noted):
    """An index of so much of the other training's is none yet; one of so much of its counterpart decides something."""
    behaviour = decompose(curves_of([[1.0]], [[factor * 0.01]], [[1.0]], [[1.0]])).positive.behaviour
    assert (behaviour.near_zero is not None) == is_noted
    runs = [[-factor * 1e-4, 1.0 + factor * 1e-4]]
    near_zero = decompose(curves_of(*[runs] * 4)).negative.eta.near_zero
    assert near_zero == ("I_N of the baseline is near zero beside I_P of the same runs" if is_noted else None)


def test_recorded_indices_are_compared_where_nothing_was_scored_again():
    """Without the two rulers an index near zero beside the other group's is all that can be seen."""
    scored = curves_of([[1.0]], [[1.0]], [[1.0]], [[1000.0]])
    eta = decompose({pair: scored[pair] for pair in (BB, KK)}).eta_p
    assert eta.value == 1000.0
    assert eta.near_zero == "I_P of the baseline is near zero beside that of the proposed reward"


# Splits that are missing


@pytest.mark.parametrize("scored", [(), (BK,), (KB,)])
def test_without_both_rulers_nothing_is_split(scored):
    """Eta stands alone, and each part says what is missing; for no reason that was given it was not scored again."""
    curves = curves_of(*[dip_and_climb(5)] * 4)
    kept = {pair: curves[pair] for pair in (BB, KK, *scored)}
    found, nothing = decompose(kept, missing="no distances in a.csv"), Estimate(None, notes=("no distances in a.csv",))
    for split in splits_of(found):
        assert split.eta.value == split.per_seed.value == 1.0
        assert split.ruler == split.behaviour == split.interaction == nothing
        assert (split.paths, split.is_scored) == ((), False)
    assert (found.total.change.value, found.total.ruler.value, found.is_split) == (0.0, None, False)
    found = decompose(kept)
    assert found.positive.ruler.note == found.total.ruler.note == "not re-scored"


# Intervals


def slow_ends(baseline, proposed, sign):
    """The jackknife of the logarithm of one index's ratio, in loops."""

    def logarithm(rows):
        sums = []
        for runs in (proposed, baseline):
            curve = [sum(runs[row][: step + 1].sum() for row in rows) / len(rows) for step in range(runs.shape[1])]
            sums.append(abs(sum(value for value in curve if value * sign > 0)))
        return float(np.log(sums[0] / sums[1]))

    count = len(baseline)
    rows = list(range(count))
    left_out = [logarithm(rows[:out] + rows[out + 1 :]) for out in rows]
    mean = sum(left_out) / count
    error = ((count - 1) / count * sum((value - mean) ** 2 for value in left_out)) ** 0.5
    reach = float(scipy.stats.t.ppf(0.975, count - 1)) * error
    return [float(np.exp(logarithm(rows) + side * reach)) for side in (-1.0, 1.0)]


def test_interval_agrees_with_a_slow_jackknife():
    """In loops, for both indices."""
    baseline, proposed = dip_and_climb(6), 1.5 * dip_and_climb(6, seed=7)
    found = eta_of(baseline, proposed)
    assert ends(found.eta_n) == pytest.approx(slow_ends(baseline, proposed, -1), rel=1e-9)
    assert ends(found.eta_p) == pytest.approx(slow_ends(baseline, proposed, 1), rel=1e-9)


def logarithms_of(runs):
    """Of every run's own I_P."""
    return np.log(np.maximum(np.cumsum(runs, axis=1), 0.0).sum(axis=1))


def test_per_seed_is_the_geometric_mean_with_students_interval():
    """Each seed's own eta, its logarithm, and scipy's interval of their mean."""
    baseline, proposed = dip_and_climb(6), 1.5 * dip_and_climb(6, seed=7)
    logarithms = logarithms_of(proposed) - logarithms_of(baseline)
    interval = scipy.stats.ttest_1samp(logarithms, 0.0).confidence_interval()
    per_seed = eta_of(baseline, proposed).positive.per_seed
    assert per_seed.value == pytest.approx(np.exp(logarithms.mean()))
    assert ends(per_seed) == pytest.approx(list(np.exp([interval.low, interval.high])), rel=1e-6)


def test_seeds_without_an_index_under_the_other_reward_have_their_etas():
    """Only its own reward scores a training here."""
    runs, never = dip_and_climb(3), np.ones((3, 60))
    assert decompose(curves_of(runs, never, never, runs)).negative.per_seed.value == pytest.approx(1.0)


def test_pairs_matter():
    """Twice the same runs have a ratio of 2 without any seed; with the pairs broken up the interval has a width."""
    runs = dip_and_climb(6)
    paired, broken = eta_of(runs, 2.0 * runs).eta_p, eta_of(runs, 2.0 * runs[::-1]).eta_p
    assert ends(paired) == pytest.approx([2.0, 2.0])
    assert broken.high - broken.low > 0.01


def test_unpaired_groups_have_welchs_interval():
    """Per-seed etas are differences of mean logarithms: scipy knows the interval for groups without pairs."""
    one, other = dip_and_climb(5), 2.0 * dip_and_climb(8, seed=2, noise=2.0)
    interval = scipy.stats.ttest_ind(logarithms_of(other), logarithms_of(one), equal_var=False).confidence_interval()
    per_seed = eta_of(one, other, paired=False).positive.per_seed
    assert ends(per_seed) == pytest.approx(list(np.exp([interval.low, interval.high])), rel=1e-6)


def test_rulers_are_paired_also_where_seeds_are_not():
    """One training under two rewards is the same runs: of a scaled reward both rulers have no width."""
    b, k = dip_and_climb(6), 3.0 * dip_and_climb(4, seed=2)
    for split in splits_of(decompose(curves_of(b, k, 2.0 * b, 2.0 * k), paired=False)):
        for path in split.paths:
            assert ends(path.ruler) == pytest.approx([2.0, 2.0])
        assert split.behaviour.high > split.behaviour.low


def test_groups_of_different_size_cannot_be_paired():
    """Numbers of runs that differ are taken as unpaired, whatever was said."""
    b, k = dip_and_climb(6), dip_and_climb(4, seed=2)
    assert eta_of(b, k, paired=True) == eta_of(b, k, paired=False)


def test_one_seed_has_a_value_and_nothing_else():
    """Nothing can be said about the spread of one run."""
    runs = dip_and_climb(1)
    for split in splits_of(eta_of(runs, 2.0 * runs)):
        assert split.eta == Estimate(2.0, seeds=1, notes=("one seed: no interval below 3 seeds",))
        assert (split.p, split.corrected, split.outcomes) == (None, None, None)


def spread_curves(spread, seeds):
    """Runs of one step whose logarithms have exactly this standard deviation; the ruler is 2 and a little."""
    runs = np.exp(spread * scipy.stats.zscore(default_rng(1).normal(size=seeds), ddof=1))[:, None]
    ruled = runs * np.exp(0.01 * default_rng(2).normal(size=(seeds, 1)))
    return curves_of(runs, runs[::-1], 2.0 * ruled, 2.0 * ruled[::-1])


@pytest.mark.parametrize(
    ("spread", "seeds", "given"), [(0.7, 20, True), (0.9, 20, False), (0.3, 3, True), (0.4, 3, False)]
)
def test_ruler_of_unlike_seeds_has_no_interval(spread, seeds, given):
    """A spread that is likely at most 1 is alike: 0.78 of 20 seeds, 0.32 of three. Eta and behaviour keep theirs."""
    split = decompose(spread_curves(spread, seeds)).positive
    for ruler in (split.ruler, split.interaction, *(path.ruler for path in split.paths)):
        assert (ruler.low is not None) == given
        assert given or ruler.note.startswith("no interval: single seeds' I_P may differ so much")
    assert None not in (split.ruler.value, split.eta.low, split.behaviour.low)


# What else is told


def test_p_value_is_that_of_swapped_trainings():
    """Both runs of a seed change sides, in all ways, and the index of both mean curves is taken anew; in loops."""
    baseline, proposed = dip_and_climb(5), 1.1 * dip_and_climb(5, seed=1)
    differences = []
    for signs in swaps_of(range(5)).signs:
        kept = signs[:, None] > 0.0
        sides = np.where(kept, proposed, baseline), np.where(kept, baseline, proposed)
        sums = [np.maximum(np.cumsum(side, axis=1).mean(axis=0), 0.0).sum() for side in sides]
        differences.append(sums[0] - sums[1])
    split = eta_of(baseline, proposed).positive
    assert split.outcomes == pytest.approx(np.array(differences))
    assert split.p == p_of(np.array(differences))


def test_clear_difference_has_a_small_p_value():
    """Three times the reward in every seed is no chance, with or without pairs."""
    runs = dip_and_climb(8)
    assert eta_of(runs, 3.0 * runs).positive.p == 2.0**-7
    assert eta_of(runs, 3.0 * runs, paired=False).positive.p < 0.01
    assert eta_of(runs, dip_and_climb(8, seed=1)).positive.p > 0.05


def test_same_runs_have_no_difference_in_any_way():
    """Not even that of the last bit, which would be the same in all seeds."""
    runs = dip_and_climb(9)
    for split in splits_of(eta_of(runs, runs.copy())):
        assert not split.outcomes.any()


def test_given_ways_are_tried():
    """Those of the whole experiment, so that its claims are swapped together."""
    signs = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, 1.0]])
    curves = {BB: curve_of(list(dip_and_climb(3))), KK: curve_of(list(dip_and_climb(3, seed=1)))}
    assert len(decompose(curves, signs=signs).positive.outcomes) == 2


def test_behaviours_on_either_side_of_one_are_told():
    """Under the baseline reward the runs got better, under the proposed one worse."""
    split = decompose(curves_of([[1.0]], [[2.0]], [[4.0]], [[2.0]])).positive
    told = "the behaviour depends on who judges it: x 2 under the baseline reward, x 0.5 under the proposed one"
    assert split.opposition == told
    assert told in split.flags
    for others in ([[2.0]], [[4.0]], [[5.0]]), ([[0.001]], [[1.0]], [[2.0]]):  # the second says little: it is near zero
        assert decompose(curves_of([[1.0]], *others)).positive.opposition == ""


@pytest.mark.parametrize(("single", "flagged"), [(1.4, False), (1.7, True), (0.9, True)])
def test_mean_curve_that_says_something_else_than_seeds_is_told(single, flagged):
    """Beyond a factor of 1.5, or on the other side of 1: a large run decides the mean curve alone."""
    baseline, factor = np.array([[1.0], [1.0], [1000.0]]), 1.1
    others = (single**3 / factor) ** 0.5
    split = eta_of(baseline, baseline * np.array([[others], [others], [factor]])).positive
    assert split.eta.value == pytest.approx(factor, rel=0.01)
    assert split.per_seed.value == pytest.approx(single)
    told = f"1.1 of the mean curve is not what seeds show one by one: their geometric mean is {single:.3g}"
    assert split.averaging == (told if flagged else "")
    assert split.flags == ((told,) if flagged else ())


def noises_of(runs, control=None):
    """Of I_N and of I_P."""
    curve = curve_of(list(runs))
    found = decompose({BB: curve, KK: curve}, control=control if control is None else curve_of(list(control)))
    return [split.noise for split in splits_of(found)]


def all_halves(runs):
    """The logarithm of I_P's ratio between halves, for every way to take half of the runs."""
    curves, logarithms = np.cumsum(runs, axis=1), []
    for half in itertools.combinations(range(len(runs)), len(runs) // 2):
        rest = [run for run in range(len(runs)) if run not in half]
        one, other = (np.maximum(curves[list(part)].mean(axis=0), 0.0).sum() for part in (half, rest))
        logarithms.append(np.log(one / other))
    return np.array(logarithms)


def test_noise_floor_is_about_one():
    """Halves of the baseline's own seeds differ by the noise: 1 lies inside, and more noise makes it wider."""
    quiet, loud = (noises_of(dip_and_climb(8, noise=noise))[1] for noise in (0.5, 2.0))
    for noise in (quiet, loud):
        assert (noise.value, noise.note) == (1.0, "halves of 8 runs, scaled to all")
        assert noise.low < 1.0 < noise.high
    assert np.log(loud.high / loud.low) > 2.0 * np.log(quiet.high / quiet.low)


def test_halves_are_scaled_to_all():
    """Of 6 runs there are 20 ways to take 3; groups of 6 differ by a root of 2 less; t of 5 degrees of freedom."""
    expected = np.quantile(all_halves(dip_and_climb(6)), [0.025, 0.975]) * 0.5**0.5 * 2.571 / 1.960
    assert np.log(ends(noises_of(dip_and_climb(6))[1])) == pytest.approx(expected, rel=0.05)


def test_control_is_as_large_as_what_is_compared():
    """Halves of the baseline's runs and of those of the control together, in any mixture, as they are."""
    runs, again = dip_and_climb(4), dip_and_climb(4, seed=1)
    noise = noises_of(runs, again)[1]
    expected = np.quantile(all_halves(np.concatenate([runs, again])), [0.025, 0.975]) * 2.365 / 1.960
    assert np.log(ends(noise)) == pytest.approx(expected, rel=0.15)
    assert noise.note == "the baseline trained again with other seeds"


def test_each_index_has_its_own():
    """The height of the climb varies more than the depth of the dip."""
    negative, positive = (np.ptp(np.log(ends(noise))) for noise in noises_of(dip_and_climb(8)))
    assert positive > 1.2 * negative


@pytest.mark.parametrize("runs", [1, 2, 3])
def test_noise_floor_needs_four_runs(runs):
    """Halves of fewer are single runs; those of a control count too."""
    reason = f"{runs} runs of the baseline: halves of them need at least 4"
    assert noises_of(dip_and_climb(runs))[1] == Estimate(None, notes=(reason,))
    assert noises_of(dip_and_climb(runs), dip_and_climb(4 - runs, seed=1))[1].value == 1.0


def test_halves_without_an_index_leave_no_floor():
    """A half that never falls below zero has nothing to divide by."""
    runs = np.ones((4, 5))
    runs[0] = -9.0
    assert noises_of(runs)[0] == Estimate(None, notes=("a half of the baseline's runs has an index of 0",))


@pytest.mark.parametrize("count", [4, 5, 8])
def test_halves_are_disjoint_and_equally_large(count):
    """Each run is in one half at most, of an odd number one in none; they are drawn at random, the same each time."""
    first, second = split_halves(count)
    assert first.shape == second.shape == (200, count)
    assert not (first * second).any()
    for half in (first, second):
        assert_array_equal((half > 0.0).sum(axis=1), count // 2)
        assert_allclose(half.sum(axis=1), 1.0)
        assert half.any(axis=0).all()
    assert_array_equal(first, split_halves(count)[0])
