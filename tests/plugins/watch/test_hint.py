"""A hint appears where pay rises while behaviour falls, and seldom elsewhere."""

import math

import numpy as np
import pyarrow.parquet as pq
import pytest
from numpy.random import default_rng
from scipy import stats

from harness_plugins.watch.blocks import Block, Blocks
from harness_plugins.watch.hint import _pairs, _Series, hint_of
from tests.plugins.watch.cases.make import KEPT
from tests.plugins.watch.cases.nulls import NULLS, count_hints
from tests.plugins.watch.cases.table import CASES

LATER = np.arange(256) >= 128
"""The second half of 256 episodes."""


@pytest.fixture
def rng():
    """The same numbers in each test."""
    return default_rng(0)


def blocks_of(pay, behaviour, steps=None):
    """Of episodes."""
    numbers = np.column_stack([pay, behaviour]).astype(float)
    return Blocks.of((), 100 * np.arange(1, len(numbers) + 1) if steps is None else steps, numbers).listed


def hacked(rng, falls=0.6):
    """Of 256 episodes: after half of them pay rises by 2 and success falls."""
    return 1.0 + 2.0 * LATER + 0.3 * rng.normal(size=256), rng.random(256) < 0.9 - falls * LATER


def test_hint_says_what_rose_and_what_fell_since_when(rng):
    """Pay of 1 becomes 3 and success of 90 % becomes 30 % after 12,800 steps."""
    found = hint_of(blocks_of(*hacked(rng)), better="higher")
    assert found.pay == pytest.approx((1.0, 3.0), abs=0.2)
    assert found.behaviour == pytest.approx((0.9, 0.3), abs=0.15)
    assert found.since <= 12_800
    before, now = (f"{100 * it:.0f} %" for it in found.behaviour)
    assert found.text.endswith(f"while success fell from {before} to {now}. It is a hint, not a verdict.")


@pytest.mark.parametrize("signs", [(1, 1), (-1, 1), (-1, -1), (0, 1), (1, 0)])
def test_no_hint_unless_pay_rises_and_behaviour_falls(signs, rng):
    """Of the nine ways in which both may move one alone has a hint: here five others, the first as large as that."""
    pay, behaviour = signs
    noise = rng.normal(size=(2, 256))
    moved = pay * 3.0 * LATER + noise[0], behaviour * 3.0 * LATER + noise[1]
    assert hint_of(blocks_of(*moved), better="higher") is None


def test_distance_that_grows_is_worse(rng):
    """Where less is better a rise is what is hinted at."""
    pay, distance = 3.0 * LATER + rng.normal(size=256), 0.2 + 0.2 * LATER + 0.02 * rng.normal(size=256)
    assert hint_of(blocks_of(pay, distance), better="higher") is None
    assert "while distance rose from 0.196 to 0.398" in hint_of(blocks_of(pay, distance), "lower", "distance").text


def test_small_fall_of_success_does_not_matter(rng):
    """From 90 % to 85 % in 100,000 episodes is certain, and less than a tenth."""
    later = np.arange(100_000) >= 50_000
    behaviour = rng.random(100_000) < 0.9 - 0.05 * later
    assert hint_of(blocks_of(3.0 * later + rng.normal(size=100_000), behaviour), better="higher") is None


@pytest.mark.parametrize("count", [0, 1, 7, 8])
def test_few_episodes_have_no_hint(count):
    """Two windows of four blocks need eight."""
    assert hint_of(blocks_of(np.arange(count), -np.arange(count)), better="higher") is None


def test_nothing_measured_has_no_hint(rng):
    """A training without a measure has NaN."""
    pay, behaviour = hacked(rng)
    assert hint_of(blocks_of(pay, np.full_like(behaviour, np.nan, float)), better="higher") is None


def test_block_that_is_not_full_is_left_out(rng):
    """What is hinted at does not depend on it."""
    blocks = blocks_of(*hacked(rng))
    mutant = (*blocks, Block(30_000, 1, 1e9, math.nan, 1e9, math.nan))
    assert hint_of(mutant, better="higher") == hint_of(blocks, better="higher")


def test_surprise_is_that_of_a_t_test(rng):
    """With nothing but white noise it is scipy's p, up to how the error is estimated."""
    means = rng.normal(size=32) + np.repeat([0.0, 3.0], 16)
    series = _Series(means, np.zeros(32), is_share=False)
    (pair,) = [it for it in _pairs(32) if it.width == 16]
    expected = -np.log(stats.ttest_ind(means[16:], means[:16], alternative="greater").pvalue)
    assert series.surprise(pair) < expected * 1.5
    assert series.surprise(pair) > expected / 3.0


def test_all_looks_of_all_sizes_share_the_error():
    """The levels of all pairs that 64 blocks of any size can make add up to the error at most."""
    spent = 0.0
    for size in range(60):
        pairs = {pair for count in range(1, 65) for pair in _pairs(count)}
        spent += sum(math.exp(-pair.needed(2**size)) for pair in pairs)
    assert spent == pytest.approx(0.05 * 60 / 61)
    assert {pair.width for pair in pairs} == {4, 8, 16}


@pytest.mark.parametrize("kind", ["pay rises, success 50 %", "behaviour falls"])
def test_simulated_error_is_small(kind):
    """Of five trainings of a null none has a hint."""
    assert count_hints(kind, 5) == 0


@pytest.mark.slow
@pytest.mark.parametrize("kind", [it for it in NULLS if "0.9" not in it])
def test_error_over_all_looks_is_at_most_what_is_promised(kind):
    """Of 100 trainings of each null at most 9 have a hint at any look: of 5 % more are met once in 40."""
    assert count_hints(kind, 100) <= 9


def recorded():
    """Each kept training: case, steps, pay, behaviour."""
    rows = {name: np.array(column) for name, column in pq.read_table(KEPT).to_pydict().items()}
    for case in CASES:
        for seed in np.unique(rows["seed"][rows["case"] == case.name]):
            of_it = (rows["case"] == case.name) & (rows["seed"] == seed)
            yield case, *(rows[it][of_it] for it in ("steps", "pay", "behaviour"))


def has_hint(case, steps, pay, behaviour, share):
    """At one of twenty looks before this share of the training."""
    for until in np.linspace(0.0, share, 21)[1:] * steps[-1]:
        there = steps <= until
        blocks = blocks_of(pay[there], behaviour[there], steps[there])
        if hint_of(blocks, case.better, case.measure):
            return True
    return False


def test_honest_recorded_trainings_have_no_hint():
    """At most 2, of those of `tests.plugins.watch.cases.table`."""
    honest = [it for it in recorded() if not it[0].is_hacked]
    assert len(honest) >= 20
    assert sum(has_hint(*it, share=1.0) for it in honest) <= 2


@pytest.mark.parametrize("case", ["coins again", "coins locked", "coins sometimes", "cartpole steady reinforce"])
def test_hacked_recorded_trainings_have_a_hint_before_half(case):
    """Where the untrained robot, or one half trained, did better for a tenth of the training."""
    hints = [has_hint(*it, share=0.5) for it in recorded() if it[0].name.startswith(case)]
    assert len(hints) == 3
    assert all(hints)


def got_worse(case, steps, pay, behaviour):
    """Whether the last tenth of a training behaves worse than an earlier one, and is paid more.

    Worse by 0.1 of success, or by half a standard deviation of the earlier tenth.
    """
    better = -behaviour if case.better == "lower" else behaviour
    tenths = [steps * 10 // (steps[-1] + 1) == it for it in range(10)]
    tenths = [it for it in tenths if it.any()]
    is_share = set(np.unique(behaviour)) <= {0.0, 1.0}
    last = tenths[-1]
    return any(
        better[it].mean() - better[last].mean() >= (0.1 if is_share else 0.5 * better[it].std())
        and pay[last].mean() > pay[it].mean()
        for it in tenths[:-1]
    )


def test_two_thirds_of_the_hacked_trainings_that_got_worse_have_a_hint_before_half():
    """12 of 18. The other hacked trainings behave in the end as they did before: there nothing falls."""
    worse = [it for it in recorded() if it[0].is_hacked and got_worse(*it)]
    assert len(worse) == 18
    assert sum(has_hint(*it, share=0.5) for it in worse) >= 12


def test_where_nobody_says_what_is_better_nothing_is_hinted_at(rng):
    """The same blocks as those with a hint, of a measure of which nobody said it."""
    blocks = blocks_of(*hacked(rng))
    assert hint_of(blocks, better="higher") is not None
    assert hint_of(blocks, better="") is None
