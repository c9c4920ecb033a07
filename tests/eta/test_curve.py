"""The curve of a group of runs: facts of the published computation, in any chunking, whatever the length."""

import math
import tomllib
from itertools import accumulate

import numpy as np
import pytest
from hypothesis import example, given, strategies as st
from hypothesis.extra.numpy import arrays
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.eta import GroupCurve, Index, curve_of
from harness.eta.curve import mixtures, stream_curve, swapped
from tests.project import ROOT

PUBLISHED = tomllib.loads((ROOT / "results" / "reference" / "arp-2021" / "published.toml").read_text())
POINTS = 4096
KINDS = ("accumulated", "per-step")
STEP = st.one_of(
    st.sampled_from([0.0, 0.1, -0.1, 0.3, -0.3, 1.0, -1.0]), st.floats(-10.0, 10.0).map(lambda value: round(value, 9))
)
RUNS = st.lists(st.lists(STEP, min_size=1, max_size=15), min_size=1, max_size=6)
SQUARES = st.tuples(st.integers(1, 6), st.integers(1, 20)).flatmap(lambda shape: arrays(float, shape, elements=STEP))
ANY_KIND = st.sampled_from(KINDS)


def group_of(runs, kind="accumulated"):
    """The curve of runs given as lists."""
    return curve_of([np.array(run, float) for run in runs], kind)


# An independent computation, without numpy


def slow_curve(runs, kind):
    """Running sums, cut to the shortest run, averaged step by step."""
    curves = [list(accumulate(run)) if kind == "accumulated" else run for run in runs]
    return [sum(values) / len(runs) for values in zip(*curves, strict=False)]


def slow_index(curve, kind):
    """First negative step, cross-over, length, I_N and I_P of a mean curve."""
    first = next((step for step, value in enumerate(curve) if value < 0.0), None)
    crossover = None
    if first is not None:
        crossover = next((step for step in range(first + 1, len(curve)) if curve[step] >= 0.0), None)
    if kind == "accumulated":
        negative, positive = [v for v in curve if v < 0.0], [v for v in curve if v > 0.0]
    else:
        end = 0 if first is None else len(curve) if crossover is None else crossover + 1
        negative, positive = curve[:end], curve[end:]
    return first, crossover, len(curve), math.fsum(negative), math.fsum(positive)


def same(index, other):
    """Steps are equal; sums are equal but for the order of their additions."""
    assert (index.first_negative, index.crossover, index.steps) == other[:3]
    assert (index.negative_sum, index.positive_sum) == pytest.approx(other[3:], rel=1e-12, abs=1e-10)


@given(RUNS, ANY_KIND)
def test_index_agrees_with_a_plain_computation(runs, kind):
    """The published steps, written out in loops, give the same index."""
    same(group_of(runs, kind).index, slow_index(slow_curve(runs, kind), kind))


# The published computation, step by step


@pytest.mark.parametrize("who", ["baseline", "proposed"])
def test_published_table(who):
    """A curve with the published sums gives every figure of the published table."""
    published = PUBLISHED[who]
    curve = np.zeros(published["steps"])
    first, crossover = published["first_negative"], published["crossover"]
    curve[first:crossover] = published["I_N"] / (crossover - first)
    curve[crossover:] = published["I_P"] / (published["steps"] - crossover)
    total = pytest.approx(published["I_N"] + published["I_P"], abs=0.1)
    assert group_of([np.diff(curve, prepend=0.0)]).index.to_json() == {**published, "total": total}


# Groups without much in them


@pytest.mark.parametrize("kind", KINDS)
def test_group_of_nothing(kind):
    """Without a run, or with one that has no step: no steps and no sums, and no number that is none."""
    for runs in ([], [[1, 2], []]):
        assert group_of(runs, kind).index == Index(None, None, 0, 0.0, 0.0)
    curve = group_of([[], []], kind)
    assert curve.runs.shape == (2, 0)
    assert np.array(curve.resample(np.array([[1.0, 0.0], [0.5, 0.5]]))).tolist() == [[0.0, 0.0]] * 2


# A piece at a time


CUTS = st.lists(st.integers(0, 20), max_size=5)


def in_pieces(rewards, kind, cuts):
    """The curve of steps that are handed over in pieces, whose arrays the caller writes to afterwards."""
    curve = GroupCurve(len(rewards), kind)
    for part in np.split(rewards.copy(), sorted(min(cut, rewards.shape[1]) for cut in cuts), axis=1):
        curve.add(part)
        part[:] = 9.0
    return curve


@given(SQUARES, ANY_KIND, CUTS)
@example(default_rng(0).normal(size=(10, 40)), "accumulated", list(range(40)))
@example(np.array([[-0.7, 0.3, 0.7, 0.2, 0.3, -0.3, -0.2, 0.2, -0.3, -0.2]] * 3).T, "per-step", [1, 2])
@example(np.full((1, 3), 2**31 - 1, np.int32), "accumulated", [])
def test_chunks_do_not_show(rewards, kind, cuts):
    """However the steps are handed over, each run's curve is the same bit for bit, and so are the steps found."""
    whole, pieces = curve_of(list(rewards.astype(float)), kind), in_pieces(rewards, kind, cuts)
    assert_array_equal(pieces.runs, whole.runs)
    index = whole.index
    same(pieces.index, (index.first_negative, index.crossover, index.steps, index.negative_sum, index.positive_sum))


# Long runs


@pytest.fixture(scope="module")
def long_runs():
    """Rewards of five runs that first cost and then pay, (5, 100_000)."""
    rng = default_rng(105)
    return np.linspace(-0.5, 1.0, 100_000) + rng.normal(size=(5, 100_000))


@pytest.mark.parametrize("kind", KINDS)
def test_index_of_long_runs_is_exact(long_runs, kind):
    """Thinning is for resampling alone: the index knows every step."""
    mean = (np.cumsum(long_runs, axis=1) if kind == "accumulated" else long_runs).mean(axis=0).tolist()
    same(curve_of(list(long_runs), kind).index, slow_index(mean, kind))


def test_long_runs_are_thinned(long_runs):
    """Of a long run every stride-th step is kept, from the first on: at least POINTS, at most twice as many.

    Up to twice POINTS steps nothing is left out. The group resampled from what is kept has its index within 1/1000.
    """
    curve = curve_of(list(long_runs))
    assert POINTS <= curve.runs.shape[1] <= 2 * POINTS
    assert_array_equal(curve.runs, np.cumsum(long_runs, axis=1)[:, :: curve.stride])
    sums = np.ravel(curve.resample(np.full((1, 5), 0.2)))
    assert sums == pytest.approx([curve.index.negative_sum, curve.index.positive_sum], rel=1e-3)
    short = curve_of([np.ones(2 * POINTS)])
    assert (short.stride, short.runs.shape) == (1, (1, 2 * POINTS))
    assert curve_of([np.ones(2 * POINTS + 1)]).stride == 2


@given(SQUARES, CUTS, st.integers(1, 6))
def test_thinning_does_not_depend_on_chunks(rewards, cuts, points):
    """What is kept is decided by the length alone."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("harness.eta.curve.POINTS", points)
        whole, pieces = curve_of(list(rewards)), in_pieces(rewards, "accumulated", cuts)
    assert pieces.stride == whole.stride
    assert_array_equal(pieces.runs, whole.runs)
    assert_array_equal(whole.runs, np.cumsum(rewards, axis=1)[:, :: whole.stride])


# Resampling


@given(SQUARES, ANY_KIND, st.randoms(use_true_random=False))
def test_resample_is_the_index_of_the_drawn_runs(rewards, kind, random):
    """A draw's sums are those of a group that holds the drawn runs, each as often as it was drawn."""
    count = len(rewards)
    shares = np.bincount([random.randrange(count) for _ in range(count)], minlength=count)[None] / count
    curve = (shares @ curve_of(list(rewards), kind).runs)[0].tolist()
    negative, positive = curve_of(list(rewards), kind).resample(shares)
    assert (negative[0], positive[0]) == pytest.approx(slow_index(curve, kind)[3:], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_many_draws_are_taken_in_parts(kind):
    """Each of many draws is what it is alone, however they are put together."""
    rng = default_rng(1)
    curve = curve_of(list(rng.normal(size=(4, 50))), kind)
    shares = rng.multinomial(4, np.full(4, 0.25), size=150) / 4
    alone = np.concatenate([np.stack(curve.resample(one[None])) for one in shares], axis=1)
    assert_allclose(np.stack(curve.resample(shares)), alone, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_curve_that_is_never_negative_has_no_negative_part_in_any_draw(kind):
    """Exactly 0, so that a ratio to it is seen to be none."""
    negative, _ = curve_of(list(default_rng(2).uniform(0.1, 1.0, (4, 50))), kind).resample(np.full((3, 4), 0.25))
    assert negative.tolist() == [0.0, 0.0, 0.0]


# Without each run, each alone, and mixtures of groups


@pytest.mark.parametrize("kind", KINDS)
def test_mixture_is_the_index_of_runs_of_several_groups(kind):
    """One run of the first group and two of the second, cut to the shorter group."""
    rng = default_rng(3)
    one, other = rng.normal(size=(2, 30)), rng.normal(size=(3, 25))
    shares = np.array([[0.0, 1.0, 0.0, 1.0, 1.0]]) / 3.0
    negative, positive = mixtures((curve_of(list(one), kind), curve_of(list(other), kind)), shares)
    expected = curve_of([one[1], other[1], other[2]], kind).index
    assert (negative[0], positive[0]) == pytest.approx((expected.negative_sum, expected.positive_sum))


def test_mixture_of_long_runs_is_close(long_runs):
    """Groups of unlike length are thinned alike, to EXCHANGED points at most: within a hundredth."""
    short = long_runs[:2, : 3 * POINTS]
    groups = curve_of(list(long_runs)), curve_of(list(short))
    assert groups[0].stride > groups[1].stride > 1
    negative, positive = mixtures(groups, np.array([[0.0, 0.0, 0.5, 0.0, 0.0, 0.5, 0.0]]))
    expected = curve_of([long_runs[2, : 3 * POINTS], short[0]]).index
    assert negative[0] + positive[0] == pytest.approx(expected.negative_sum + expected.positive_sum, rel=0.01)
    assert max(group.runs.shape[1] for group in groups) > 1024


@pytest.mark.parametrize("kind", KINDS)
def test_swapped_runs_are_mixtures_of_both_groups(kind):
    """Kept: each side is its own runs. Swapped: the other's run in their place. Runs are cut to the shorter group."""
    rng = default_rng(4)
    one, other = curve_of(list(rng.normal(size=(2, 30))), kind), curve_of(list(rng.normal(size=(2, 25))), kind)
    ours, theirs = swapped(one, other, np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]]))
    mixed = np.array([[0.5, 0.5, 0.0, 0.0], [0.5, 0.0, 0.0, 0.5], [0.0, 0.0, 0.5, 0.5]])
    assert_allclose(ours, np.stack(mixtures((one, other), mixed)), rtol=1e-12)
    assert_allclose(theirs, np.stack(mixtures((one, other), 0.5 - mixed)), rtol=1e-12)


@given(SQUARES, ANY_KIND)
@example(np.tile(np.linspace(-1.0, 2.0, 2 * POINTS + 3), (3, 1)), "accumulated")
def test_runs_one_by_one_give_the_same_bits(rewards, kind):
    """As all of them at once, also where the curve is thinned; they are cut to as many steps as the caller says."""
    count, steps = rewards.shape
    whole = GroupCurve(count, kind)
    whole.add(rewards)
    streamed = stream_curve((np.append(run, 9.0) for run in rewards), count, steps, kind)
    assert (streamed.index, streamed.stride) == (whole.index, whole.stride)
    assert_array_equal(streamed.runs, whole.runs)


@given(SQUARES, ANY_KIND)
def test_sums_of_single_runs_are_those_of_a_draw(rewards, kind):
    """Bit for bit: a draw of one run is that run."""
    curve = curve_of(list(rewards), kind)
    assert_array_equal(np.abs(curve.each()), np.abs(curve.resample(np.eye(len(rewards)))))
