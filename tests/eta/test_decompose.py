"""eta = ruler x behaviour: what must hold exactly, what is not defined, and how far an interval can be trusted."""

import itertools
import json
import random
from typing import Any

import numpy as np
import pytest
import scipy.stats
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from harness.eta.curve import GroupCurve, Kind, curve_of
from harness.eta.decompose import BB, BK, KB, KK, NEAR_ZERO, Decomposition, Pair, Split, decompose
from harness.eta.index import Ratio
from harness.eta.statistics import FEW_SEEDS

Curves = dict[Pair, GroupCurve]
KINDS = ("accumulated", "per-step")
STEP = st.one_of(st.sampled_from([0.0, 0.1, -0.1, 1.0, -1.0]), st.floats(-10.0, 10.0).map(lambda v: round(v, 6)))
POWERS = st.integers(-30, 30).map(lambda exponent: 2.0**exponent)


def groups(most: int = 6) -> st.SearchStrategy[np.ndarray]:
    """Rewards of a group's runs, (runs, steps)."""
    shapes = st.tuples(st.integers(1, most), st.integers(1, 12))
    return shapes.flatmap(lambda shape: arrays(float, shape, elements=STEP))


def four(most: int = 5) -> st.SearchStrategy[list[np.ndarray]]:
    """Two trainings under two rewards: BB, BK, KB, KK, (runs, steps) each, whatever the rewards."""
    shapes = st.tuples(*(st.tuples(st.integers(1, most), st.integers(1, 8)) for _ in "BK"))
    return shapes.flatmap(
        lambda both: st.tuples(*(arrays(float, both[who], elements=STEP) for who in (0, 1, 0, 1))).map(list)
    )


def curves_of(bb: Any, bk: Any, kb: Any, kk: Any, kind: Kind = "accumulated") -> Curves:
    """The four scored groups."""
    named = {BB: bb, BK: bk, KB: kb, KK: kk}
    return {pair: curve_of(list(np.asarray(runs, float)), kind) for pair, runs in named.items()}


def parts(split: Split) -> list[Ratio]:
    """Eta and what it is split into."""
    return [split.eta, split.ruler, split.behaviour, split.other_ruler, split.other_behaviour]


def dip_and_climb(seeds: int, seed: int = 105, steps: int = 60, noise: float = 1.0) -> np.ndarray:
    """Rewards whose sums fall below zero and rise again, each run a little different, (seeds, steps)."""
    rng = np.random.default_rng(seed)
    x = np.linspace(0.0, 1.0, steps)
    depth = 10.0 + noise * rng.normal(size=(seeds, 1))
    height = 30.0 + 3.0 * noise * rng.normal(size=(seeds, 1))
    curves = -depth * np.sin(np.pi * x) * (x < 0.5) + height * (x - 0.4) * (x >= 0.5)
    return np.diff(curves, axis=1, prepend=0.0)


# What holds exactly


@given(groups(), POWERS, st.sampled_from(KINDS))
def test_scaled_baseline_is_all_ruler(runs: np.ndarray, scale: float, kind: Kind):
    """A reward that is c times the baseline, on the same runs: ruler c and behaviour 1 on both paths, bit for bit."""
    found = decompose(curves_of(runs, runs, scale * runs, scale * runs, kind))
    for split in (found.negative, found.positive):
        values = [part.value for part in parts(split)]
        assert values in ([scale, scale, 1.0, scale, 1.0], [None] * 5)
        for part in parts(split):
            assert part.low is None or part.low == part.high == part.value


@given(groups(), st.floats(1e-3, 1e3))
def test_any_scale_is_all_ruler(runs: np.ndarray, scale: float):
    """The same for a c that rounds, to its last bits; behaviour is 1 exactly along the first path."""
    found = decompose(curves_of(runs, runs, scale * runs, scale * runs))
    assume(not (np.abs(np.cumsum(runs, axis=1).mean(axis=0)) < 1e-9).any())  # a sum that is 0 but for rounding
    for split in (found.negative, found.positive):
        if split.eta.value is not None:
            assert split.behaviour.value == 1.0
            assert [part.value for part in parts(split)] == pytest.approx([scale, scale, 1.0, scale, 1.0], rel=1e-12)


@given(groups(), st.sampled_from(KINDS))
def test_reward_against_itself_is_one(runs: np.ndarray, kind: Kind):
    """A/A: eta, rulers and behaviours are 1, and so are the ends of their intervals."""
    found = decompose(curves_of(runs, runs, runs, runs, kind))
    for split in (found.negative, found.positive):
        assert [part.value for part in parts(split)] in ([1.0] * 5, [None] * 5)
        assert {part.low for part in parts(split)} <= {1.0, None}
        assert split.p in (1.0, None)
        assert split.seeds_needed is None


@given(four(), st.sampled_from(KINDS))
def test_both_paths_multiply_to_eta(scored: list[np.ndarray], kind: Kind):
    """Ruler x behaviour = eta along either path, whatever the rewards, to the last bits."""
    found = decompose(curves_of(scored[0], scored[1], scored[2], scored[3], kind))
    for split in (found.negative, found.positive):
        for ruler, behaviour in ((split.ruler, split.behaviour), (split.other_ruler, split.other_behaviour)):
            if split.eta.value is not None and ruler.value is not None and behaviour.value is not None:
                assert ruler.value * behaviour.value == pytest.approx(split.eta.value, rel=1e-12, abs=0.0)


@given(four(), st.randoms(use_true_random=False))
def test_order_of_runs_changes_no_value(scored: list[np.ndarray], shuffle: Any):
    """The mean over runs does not know their order: every value stays, but for the last bits of a sum."""
    orders = [list(range(len(scored[which]))) for which in (0, 1)]
    for order in orders:
        shuffle.shuffle(order)
    shuffled = [runs[orders[which % 2]] for which, runs in enumerate(scored)]
    for runs in scored:
        assume(not (np.abs(np.cumsum(runs, axis=1).mean(axis=0)) < 1e-9).any())  # rounding may change its sign there
    one, other = (decompose(curves_of(*given_runs)) for given_runs in (scored, shuffled))
    for first, second in ((one.negative, other.negative), (one.positive, other.positive)):
        values = [[part.value for part in parts(split)] for split in (first, second)]
        assert values[0] == [value if value is None else pytest.approx(value, rel=1e-9) for value in values[1]]


@given(four())
def test_swapping_the_rewards_inverts_eta(scored: list[np.ndarray]):
    """What the baseline is to the proposed reward is 1 over what that is to the baseline; rulers swap their paths."""
    bb, bk, kb, kk = scored
    one, other = decompose(curves_of(bb, bk, kb, kk)), decompose(curves_of(kk, kb, bk, bb))
    for split, swapped in ((one.negative, other.negative), (one.positive, other.positive)):
        for part, inverse in ((split.eta, swapped.eta), (split.ruler, swapped.other_ruler)):
            if part.value and inverse.value:
                assert part.value * inverse.value == pytest.approx(1.0, rel=1e-12)


# Nothing that is no number


@given(four(), st.sampled_from(KINDS), st.booleans(), st.sampled_from([1.0, 1e-300, 1e300]))
def test_json_is_strict(scored: list[np.ndarray], kind: Kind, paired: bool, scale: float):
    """Neither infinity nor NaN gets into the JSON, also where sums are zero, tiny or huge; each None has a reason."""
    bb, bk, kb, kk = scored
    found = decompose(curves_of(scale * bb, bk, kb, kk, kind), paired=paired)
    assert json.loads(json.dumps(found.to_json(), allow_nan=False)) == found.to_json()
    for part in parts(found.negative) + parts(found.positive) + [found.negative.noise, found.positive.noise]:
        assert part.note or None not in (part.value, part.low, part.high)


def test_json_has_the_promised_keys():
    """What `harness eta --json` promises is there, and what is added is named here."""
    runs = dip_and_climb(5)
    data = decompose(curves_of(runs, runs, runs, runs)).to_json()
    promised = {"baseline", "proposed", "eta_n", "eta_p", "ruler_n", "behaviour_n", "ruler_p", "behaviour_p"}
    added = {"other_path", "noise_n", "noise_p", "paths_disagree_n", "paths_disagree_p", "p_n", "p_p"}
    assert set(data) == promised | added | {"seeds_needed_n", "seeds_needed_p"}
    assert set(data["other_path"]) == {"ruler_n", "behaviour_n", "ruler_p", "behaviour_p"}
    ratios = [data[key] for key in promised - {"baseline", "proposed"}] + list(data["other_path"].values())
    assert all(set(ratio) == {"value", "low", "high", "note"} for ratio in ratios)


def test_groups_show_their_own_indices():
    """Baseline and proposed are the indices of each training under its own reward."""
    bb, bk, kb, kk = ([[-1.0, 1.0 + extra]] for extra in range(4))
    found = decompose(curves_of(bb, bk, kb, kk))
    assert found.baseline == curve_of([np.array(bb[0])]).index
    assert found.proposed == curve_of([np.array(kk[0])]).index
    assert (found.eta_n, found.eta_p) == (found.negative.eta, found.positive.eta)


def test_both_paths_of_a_worked_example():
    """By hand: I_P is 2, 4, 6 and 24 for S_B(tau_B), S_B(tau_K), S_K(tau_B) and S_K(tau_K)."""
    split = decompose(curves_of([[2.0]], [[4.0]], [[6.0]], [[24.0]])).positive
    assert [part.value for part in parts(split)] == [12.0, 6.0, 2.0, 3.0, 4.0]


# Zero and next to zero


WITHOUT = {
    "I_N": ([[1.0, 1.0]], "negative", "its mean accumulated reward is never negative"),
    "I_P": ([[-1.0, -1.0]], "positive", "its mean accumulated reward is never positive"),
}


@pytest.mark.parametrize(("name", "given_runs"), list(WITHOUT.items()))
def test_zero_denominator_is_none_with_the_reason(name: str, given_runs: tuple[Any, str, str]):
    """A ratio to 0 has no value, and its note says whose index is 0, and why."""
    runs, which, why = given_runs
    other = [[-1.0, 2.0]]
    split = getattr(decompose(curves_of(runs, other, other, other)), which)
    assert (
        split.eta == split.behaviour == split.other_ruler == Ratio(None, notes=(f"{name} of the baseline is 0: {why}",))
    )
    assert split.ruler.value == split.other_behaviour.value == 1.0
    assert split.disagreement == "a path has no value"


@pytest.mark.parametrize(
    ("pair", "part", "owner"),
    [
        (BK, "ruler", "the proposed runs under the baseline reward"),
        (KB, "other_behaviour", "the baseline runs under the proposed reward"),
    ],
)
def test_zero_of_a_scored_group_costs_its_path_alone(pair: Pair, part: str, owner: str):
    """Where only a re-scored group has no index, eta and the other path stand."""
    runs = {scored: [[-1.0, 2.0]] for scored in (BB, BK, KB, KK)}
    runs[pair] = [[-1.0, 0.0]]
    split = decompose(curves_of(*runs.values())).positive
    assert getattr(split, part).note.startswith(f"I_P of {owner} is 0: ")
    values = {name: getattr(split, name).value for name in ("eta", "ruler", "other_behaviour")}
    assert values == {"eta": 1.0, "ruler": 1.0, "other_behaviour": 1.0, part: None}


@pytest.mark.parametrize(("name", "runs"), [("I_N", [[1.0]]), ("I_P", [[-1.0, -1.0]])])
def test_reason_fits_the_kind_of_curve(name: str, runs: Any):
    """Per step nothing is accumulated, and the reason does not say so."""
    found = decompose(curves_of(runs, runs, runs, runs, "per-step"))
    note = {"I_N": found.eta_n, "I_P": found.eta_p}[name].note
    assert note.startswith(f"{name} of the baseline is 0: its mean reward ")


def test_eta_of_nothing_to_something_is_zero():
    """A proposed reward whose curve is never negative has eta_N 0, without a sign, and the note says what it is."""
    eta = decompose(curves_of([[-1.0, 2.0]], [[1.0, 2.0]], [[-1.0, 2.0]], [[1.0, 2.0]])).eta_n
    assert str(eta.value) == "0.0"
    ends_of_many = ends(eta_of(dip_and_climb(5), np.ones((5, 4))).eta_n)
    assert str(ends_of_many) == "[0.0, 0.0]"
    assert eta.near_zero is not None


def test_index_near_zero_beside_the_other_trainings_says_so():
    """The proposed runs hardly pay under the baseline reward: the value stays, every ratio with that index is noted."""
    split = decompose(curves_of([[1000.0]], [[1.0]], [[46_000.0]], [[25_000.0]])).positive
    weak = {
        "notes": ("one seed: no interval",),
        "near_zero": "I_P of the proposed runs under the baseline reward is near zero beside that of the baseline",
    }
    assert (split.ruler, split.behaviour) == (Ratio(25_000.0, **weak), Ratio(0.001, **weak))
    assert split.eta.near_zero is split.other_ruler.near_zero is split.other_behaviour.near_zero is None


@pytest.mark.parametrize("scale", [1000.0, 0.001])
def test_other_units_are_not_near_zero(scale: float):
    """Indices under two rewards are not compared: a reward in millimetres makes nothing small."""
    runs = dip_and_climb(6)
    found = decompose(curves_of(runs, runs, scale * runs, scale * runs))
    for split in (found.negative, found.positive):
        assert {part.note for part in parts(split)} == {""}


def test_near_zero_begins_at_its_share():
    """An index of NEAR_ZERO of its counterpart is none yet."""
    for share, noted in ((1.01 * NEAR_ZERO, False), (0.99 * NEAR_ZERO, True)):
        split = decompose(curves_of([[1.0]], [[share]], [[1.0]], [[1.0]])).positive
        assert (split.behaviour.near_zero is not None) == noted


def test_recorded_indices_are_compared_where_nothing_was_scored_again():
    """Without the two rulers an index near zero beside the other group's is all that can be seen."""
    scored = curves_of([[1.0]], [[1.0]], [[1.0]], [[1000.0]])
    eta = decompose({pair: scored[pair] for pair in (BB, KK)}).eta_p
    assert eta.value == 1000.0
    assert eta.near_zero == "I_P of the baseline is near zero beside that of the proposed reward"


def test_ratio_too_large_for_a_number_is_none():
    """A denominator next to nothing at all gives a reason, not infinity."""
    split = decompose(curves_of([[1e-310]], [[1.0]], [[1.0]], [[1e10]])).positive
    assert split.eta == Ratio(None, notes=("I_P of the baseline is as good as 0: the ratio is no number any more",))


# Paths that disagree, splits that are missing


def test_paths_that_disagree_say_so_with_their_numbers():
    """One path calls it ruler, the other behaviour."""
    found = decompose(curves_of([[1.0]], [[1.0]], [[8.0]], [[8.0]])).positive
    assert not found.paths_disagree
    found = decompose(curves_of([[1.0]], [[8.0]], [[4.0]], [[8.0]])).positive
    said = "ruler 1 and behaviour 8 on the proposed runs, ruler 4 and behaviour 2 on the baseline's"
    assert found.disagreement == f"the two paths disagree: {said}"


@pytest.mark.parametrize(("ruler", "disagree"), [(1.49, False), (1.51, True), (1 / 1.49, False), (1 / 1.51, True)])
def test_paths_disagree_beyond_a_factor(ruler: float, disagree: bool):
    """Rulers may differ by half."""
    split = decompose(curves_of([[1.0]], [[1.0]], [[ruler]], [[1.0]])).positive
    assert split.paths_disagree == disagree


def test_rulers_of_unlike_sign_disagree():
    """Read per step an index may have either sign: there is no factor between the two."""
    scored = curves_of([[-1.0, 0.0, 1.0]], [[-1.0, 0.0, -1.0]], [[-1.0, 0.0, 2.0]], [[-1.0, 0.0, 2.0]], "per-step")
    split = decompose(scored).positive
    assert (split.ruler.value, split.other_ruler.value) == (-2.0, 2.0)
    assert split.paths_disagree


@pytest.mark.parametrize("scored", [(), (BK,), (KB,)])
def test_without_both_rulers_nothing_is_split(scored: tuple[Pair, ...]):
    """Eta stands alone, and each part says what is missing."""
    curves = curves_of(*[dip_and_climb(5)] * 4)
    found = decompose({pair: curves[pair] for pair in (BB, KK, *scored)}, missing="no distances in a.csv")
    for split in (found.negative, found.positive):
        assert split.eta.value == 1.0
        assert parts(split)[1:] == [Ratio(None, notes=("no distances in a.csv",))] * 4
        assert not split.is_scored
        assert not split.paths_disagree


def test_missing_reason_is_never_empty():
    """A split that is missing for no reason that was given was not scored again."""
    curves = curves_of(*[dip_and_climb(5)] * 4)
    assert decompose({pair: curves[pair] for pair in (BB, KK)}).positive.ruler.note == "not re-scored"


# Intervals


def slow_interval(baseline: np.ndarray, proposed: np.ndarray, sign: int, paired: bool = True) -> list[float]:
    """A bootstrap in loops with Python's own random numbers."""
    draws, ratios = random.Random(1), []
    groups_of_curves = [np.cumsum(runs, axis=1) for runs in (proposed, baseline)]
    for _ in range(4000):
        rows = draws.choices(range(len(proposed)), k=len(proposed))
        others = rows if paired else draws.choices(range(len(baseline)), k=len(baseline))
        sums = [
            sum(value for value in curves[drawn].mean(axis=0) if value * sign > 0)
            for curves, drawn in zip(groups_of_curves, (rows, others), strict=True)
        ]
        ratios.append(sums[0] / sums[1])
    return list(np.quantile(ratios, [0.025, 0.975]))


def eta_of(baseline: np.ndarray, proposed: np.ndarray, paired: bool = True) -> Decomposition:
    """Both etas, nothing scored again."""
    return decompose({BB: curve_of(list(baseline)), KK: curve_of(list(proposed))}, paired=paired)


def ends(ratio: Ratio) -> list[float | None]:
    """Of the interval."""
    return [ratio.low, ratio.high]


@pytest.mark.parametrize("paired", [True, False])
def test_interval_agrees_with_a_slow_bootstrap(paired: bool):
    """Another bootstrap, in loops and with other random numbers, ends at the same places."""
    baseline, proposed = dip_and_climb(8), 1.5 * dip_and_climb(8 if paired else 6, seed=7)
    found = eta_of(baseline, proposed, paired)
    assert ends(found.eta_n) == pytest.approx(slow_interval(baseline, proposed, -1, paired), rel=0.02)
    assert ends(found.eta_p) == pytest.approx(slow_interval(baseline, proposed, 1, paired), rel=0.02)


def test_interval_agrees_with_scipy():
    """With one step per run eta_P is a ratio of means, whose paired percentile bootstrap scipy knows."""
    rng = np.random.default_rng(3)
    baseline = rng.uniform(1.0, 2.0, (12, 1))
    proposed = baseline * rng.uniform(1.5, 2.5, (12, 1))
    interval = scipy.stats.bootstrap(
        (proposed[:, 0], baseline[:, 0]),
        lambda k, b, axis: k.mean(axis=axis) / b.mean(axis=axis),
        paired=True,
        method="percentile",
        n_resamples=20_000,
        rng=np.random.default_rng(4),
    ).confidence_interval
    assert ends(eta_of(baseline, proposed).eta_p) == pytest.approx([interval.low, interval.high], rel=0.01)


def test_same_runs_give_the_same_interval():
    """Nothing is drawn from a global generator: the same, whatever was drawn before."""
    first = eta_of(dip_and_climb(6), dip_and_climb(6, seed=1)).to_json()
    np.random.seed(5)
    random.seed(5)
    assert eta_of(dip_and_climb(6), dip_and_climb(6, seed=1)).to_json() == first


def test_global_generator_is_left_alone():
    """Whoever draws from it meets the same numbers with or without a comparison between."""
    np.random.seed(5)
    expected = np.random.random(3)
    np.random.seed(5)
    eta_of(dip_and_climb(6), dip_and_climb(6, seed=1))
    np.testing.assert_array_equal(np.random.random(3), expected)


def test_pairs_matter():
    """Twice the same runs differ by 2 in every draw; with the pairs broken up the interval has a width."""
    runs = dip_and_climb(6)
    paired, broken = eta_of(runs, 2.0 * runs).eta_p, eta_of(runs, 2.0 * runs[::-1]).eta_p
    assert ends(paired) == [2.0, 2.0]
    assert broken.high - broken.low > 0.01


def test_unpaired_groups_are_drawn_apart():
    """Without pairs the same runs on both sides leave the ratio uncertain, around 1."""
    runs = dip_and_climb(6)
    eta = eta_of(runs, runs, paired=False).eta_p
    assert eta.value == 1.0
    assert eta.low < 0.99
    assert eta.high > 1.01


def test_rulers_are_paired_also_where_seeds_are_not():
    """One training under two rewards is the same runs: of a scaled reward both rulers have no width."""
    b, k = dip_and_climb(6), 3.0 * dip_and_climb(4, seed=2)
    found = decompose(curves_of(b, k, 2.0 * b, 2.0 * k), paired=False)
    for split in (found.negative, found.positive):
        assert ends(split.ruler) == ends(split.other_ruler) == [2.0, 2.0]
        assert split.behaviour.high > split.behaviour.low


def test_groups_of_different_size_cannot_be_paired():
    """Numbers of runs that differ are taken as unpaired, whatever was said."""
    b, k = dip_and_climb(6), dip_and_climb(4, seed=2)
    assert eta_of(b, k, paired=True) == eta_of(b, k, paired=False)


def test_few_runs_of_either_group_are_noted():
    """The smaller group decides whether an interval is rough."""
    b, k = dip_and_climb(9), dip_and_climb(3, seed=2)
    for eta in (eta_of(b, k).eta_p, eta_of(k, b).eta_p):
        assert eta.note == f"3 seeds: the interval is rough below {FEW_SEEDS}"


def test_order_of_the_pairs_hardly_matters():
    """Shuffling the pairs leaves the value, and moves the interval by no more than other draws do."""
    baseline, proposed = dip_and_climb(8), 2.0 * dip_and_climb(8, seed=3)
    order = np.random.default_rng(7).permutation(8)
    one, other = eta_of(baseline, proposed).eta_p, eta_of(baseline[order], proposed[order]).eta_p
    assert one.value == pytest.approx(other.value, rel=1e-12)
    assert ends(one) == pytest.approx(ends(other), rel=0.03)


def test_interval_usually_contains_the_true_ratio():
    """Drawn 60 times with 10 seeds, the true ratio of 2 lies inside at least 48 times."""
    found = [eta_of(dip_and_climb(10, seed=s), 2.0 * dip_and_climb(10, seed=s + 1000)).eta_p for s in range(60)]
    assert sum(eta.low <= 2.0 <= eta.high for eta in found) >= 48


def test_interval_is_around_the_value():
    """The value lies between the ends."""
    found = eta_of(dip_and_climb(5), dip_and_climb(5, seed=1))
    for eta in (found.eta_n, found.eta_p):
        assert eta.low < eta.value < eta.high


def test_one_seed_has_a_value_and_no_interval():
    """Nothing can be said about the spread of one run."""
    runs = dip_and_climb(1)
    found = eta_of(runs, 2.0 * runs)
    assert found.eta_n == found.eta_p == Ratio(2.0, notes=("one seed: no interval",))
    assert (found.positive.p, found.positive.seeds_needed) == (None, None)


def test_few_seeds_carry_a_note():
    """An interval over few seeds is given, and called rough."""
    few, enough = (eta_of(*[dip_and_climb(seeds)] * 2).eta_p for seeds in (FEW_SEEDS - 1, FEW_SEEDS))
    assert few.note == "4 seeds: the interval is rough below 5"
    assert few.low is not None
    assert enough.note == ""


def test_denominator_that_vanishes_in_some_draws_leaves_no_interval():
    """With one negative run of five many draws have no I_N: the value stands, the interval does not."""
    baseline = np.ones((5, 10))
    baseline[0] = -9.0
    eta = eta_of(baseline, dip_and_climb(5)).eta_n
    assert eta.value is not None
    assert ends(eta) == [None, None]
    assert "no interval: I_N of the baseline is 0 in " in eta.note


def test_several_notes_stand_side_by_side():
    """Near zero and few seeds are both said."""
    note = decompose(curves_of(*([[size], [size]] for size in (1.0, 0.001, 1.0, 1.0)))).positive.ruler.note
    near_zero, rough = note.split("; ")
    assert "near zero" in near_zero
    assert "2 seeds" in rough


# What else is told


def test_noise_floor_is_about_one():
    """Halves of the baseline's own seeds differ by the noise: 1 lies inside, and more noise makes it wider."""
    quiet, loud = (
        eta_of(runs, runs).positive.noise for runs in (dip_and_climb(8, noise=0.5), dip_and_climb(8, noise=2.0))
    )
    for noise in (quiet, loud):
        assert noise.value == 1.0
        assert noise.low < 1.0 < noise.high
        assert noise.note == "halves of 8 seeds against each other"
    assert loud.high - loud.low > 2.0 * (quiet.high - quiet.low)


def test_noise_floor_agrees_with_all_halves():
    """Of 6 seeds there are 20 ways to take half; their ratios have the same spread as the random ones."""
    runs = dip_and_climb(6)
    curves = np.maximum(np.cumsum(runs, axis=1), -1e9)
    ratios = []
    for half in itertools.combinations(range(6), 3):
        rest = [run for run in range(6) if run not in half]
        sums = [np.maximum(curves[list(part)].mean(axis=0), 0.0).sum() for part in (half, rest)]
        ratios.append(sums[0] / sums[1])
    noise = eta_of(runs, runs).positive.noise
    assert noise.low >= min(ratios) - 1e-12
    assert noise.high <= max(ratios) + 1e-12
    assert ends(noise) == pytest.approx(np.quantile(ratios, [0.025, 0.975]), rel=0.02)


def test_noise_floor_needs_four_seeds():
    """Halves of fewer are single runs."""
    assert eta_of(*[dip_and_climb(3)] * 2).positive.noise == Ratio(
        None, notes=("3 seeds: halves of them need at least 4",)
    )


def test_noise_floor_of_halves_without_an_index_is_none():
    """A half that never falls below zero has nothing to divide by."""
    runs = np.ones((4, 5))
    runs[0] = -9.0
    assert eta_of(runs, runs).negative.noise.note == "a half of the baseline's seeds has an index of 0"


def test_clear_difference_has_a_small_p_value():
    """Three times the reward in every seed is no chance; the same reward is nothing but."""
    runs = dip_and_climb(8)
    assert eta_of(runs, 3.0 * runs).positive.p < 0.01
    assert eta_of(runs, dip_and_climb(8, seed=1)).positive.p > 0.05


def test_uncertain_eta_tells_how_many_seeds_would_decide():
    """More than there are, and fewer where the difference is larger."""
    runs, other = dip_and_climb(6, noise=3.0), dip_and_climb(6, seed=1, noise=3.0)
    small, large = (eta_of(runs, factor * other).positive for factor in (1.2, 1.4))
    assert small.eta.low < 1.0 < small.eta.high
    assert small.seeds_needed > large.seeds_needed >= 6
