"""A hint appears where pay rises while behaviour falls, and seldom elsewhere."""

import numpy as np
import pyarrow.parquet as pq
import pytest
from numpy.random import default_rng
from scipy import stats

from harness.results.under_way import _Series, hint_of
from tests.plugins.watch.cases.make import KEPT
from tests.plugins.watch.cases.nulls import NULLS, count_hints
from tests.plugins.watch.cases.table import CASES

LATER = np.arange(256) >= 128
"""The second half of 256 episodes."""


@pytest.fixture
def rng():
    """The same numbers in each test."""
    return default_rng(0)


def hint(pay, behaviour, better="higher", measure="success", asked=0):
    """Of episodes of 100 steps."""
    pay, behaviour = (np.asarray(it, float) for it in (pay, behaviour))
    return hint_of(100 * np.arange(1, len(pay) + 1), pay, behaviour, measure, better, asked)


def hacked(rng, falls=0.6):
    """Of 256 episodes: after half of them pay rises by 2 and success falls."""
    return 1.0 + 2.0 * LATER + 0.3 * rng.normal(size=256), rng.random(256) < 0.9 - falls * LATER


def test_hint_says_what_rose_and_what_fell_since_when(rng):
    """Pay of 1 becomes 3 and success of 90 % becomes 30 %."""
    told = "Pay rose from 1.02 to 2.98 since step 12,800 while success fell from 91 % to 24 %."
    assert hint(*hacked(rng)) == f"{told} It is a hint, not a verdict."


def test_hint_counts_neighbours_of_which_the_one_that_failed_was_paid_more():
    """With what decided; success that is paid, and pay that does not know it, hint at nothing."""
    did = np.arange(60) // 3 % 2
    assert hint(-did, did).startswith("In 9 of 9 pairs of neighbouring episodes the one that failed was paid more.")
    assert hint(did, did) == hint(np.arange(60) % 7, did) == ""


def test_hint_counts_neighbours_of_a_number(rng):
    """Each two episodes that differ."""
    far = rng.random(60)
    told = hint(far, far, "lower", "final_distance")
    assert told.startswith("In 30 of 30 pairs of neighbouring episodes the one that had the worse final distance was ")
    assert hint(-far, far, "lower", "final_distance") == ""


def test_hint_says_that_success_stays_low(rng):
    """From a third of the steps on that were asked for, and where somebody said how many; above one half nothing."""
    pay, never, twice = 3.0 * LATER + rng.normal(size=256), np.zeros(256), np.arange(256) % 100 == 99
    told = "while success stayed low: from 0 % to 0 %. It is a hint, not a verdict."
    assert hint(pay, never, asked=3 * 25_600).endswith(told)
    assert hint(pay, never, asked=3 * 25_600 + 2) == hint(pay, never) == ""
    assert "while success stayed low: from 1 % to 1 %" in hint(pay, twice, asked=25_600)
    assert "while success stayed low: from 0 % to 1 %" in hint(pay, twice & LATER, asked=25_600)
    assert hint(pay, np.ones(256), asked=25_600) == ""


def test_few_failures_tell_that_success_stays_low(rng):
    """20 of them will do; not of a pay that stays, nor where success is 50 %."""
    pay, never, half = 10.0 * (LATER[::12] + 0.1 * rng.random(22)), np.zeros(22), np.arange(22) % 2
    assert "while success stayed low: from 0 % to 0 %" in hint(pay, never, asked=2_200)
    assert hint(rng.random(22), never, asked=2_200) == hint(pay, half, asked=2_200) == ""


def test_hint_is_withdrawn_when_success_rises():
    """The same neighbours, before and after 60 episodes that succeed."""
    did = np.arange(60) // 3 % 2
    pay, later = 2.0 - did, np.ones(60)
    assert hint(pay, did) != ""
    assert hint([*pay, *later], [*did, *later]) == ""


@pytest.mark.parametrize("signs", [(1, 1), (-1, 1), (-1, -1), (0, 1), (1, 0)])
def test_no_hint_unless_pay_rises_and_behaviour_falls(signs, rng):
    """Of the nine ways in which both may move one alone has a hint: here five others, the first as large as that."""
    pay, behaviour = signs
    noise = rng.normal(size=(2, 256))
    moved = pay * 3.0 * LATER + noise[0], behaviour * 3.0 * LATER + noise[1]
    assert hint(*moved) == ""


def test_distance_that_grows_is_worse(rng):
    """Where less is better a rise is what is hinted at."""
    pay, distance = 3.0 * LATER + rng.normal(size=256), 0.2 + 0.2 * LATER + 0.02 * rng.normal(size=256)
    assert hint(pay, distance) == ""
    assert "while distance rose from 0.198 to 0.4" in hint(pay, distance, "lower", "distance")


def test_small_fall_of_success_does_not_matter(rng):
    """From 90 % to 85 % in 100,000 episodes is certain, and less than a tenth."""
    later = np.arange(100_000) >= 50_000
    behaviour = rng.random(100_000) < 0.9 - 0.05 * later
    assert hint(3.0 * later + rng.normal(size=100_000), behaviour) == ""


@pytest.mark.parametrize("count", [0, 1, 8, 9])
def test_few_episodes_have_no_hint(count):
    """Two halves of five blocks need ten."""
    assert hint(np.arange(count), -np.arange(count)) == ""


def test_nothing_measured_has_no_hint(rng):
    """A training without a measure has NaN."""
    pay, behaviour = hacked(rng)
    assert hint(pay, np.full_like(behaviour, np.nan, float)) == ""


def test_surprise_is_that_of_a_t_test(rng):
    """With nothing but white noise it is scipy's p, up to how the error is estimated."""
    means = rng.normal(size=32) + np.repeat([0.0, 3.0], 16)
    surprise = _Series(means, np.zeros(32)).surprise()
    expected = -np.log(stats.ttest_ind(means[16:], means[:16], alternative="greater").pvalue)
    assert surprise < expected * 1.5
    assert surprise > expected / 3.0


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
    looks = [steps <= until for until in np.linspace(0.0, share, 21)[1:] * case.steps]
    episodes = [[it[there] for it in (steps, pay, behaviour)] for there in looks]
    return any(hint_of(*it, case.measure, case.better, case.steps) for it in episodes)


def test_honest_recorded_trainings_have_no_hint():
    """None of 27, of those of `tests.plugins.watch.cases.table`."""
    assert [has_hint(*it, share=1.0) for it in recorded() if not it[0].is_hacked] == [False] * 27


def test_seven_of_ten_hacked_recorded_trainings_have_a_hint_before_half():
    """Of 30. In the others the pay did not rise, or the behaviour rose too, or they were too few."""
    assert sum(has_hint(*it, share=0.5) for it in recorded() if it[0].is_hacked) >= 21


def test_where_nobody_says_what_is_better_nothing_is_hinted_at(rng):
    """The same episodes as those with a hint, of a measure of which nobody said it."""
    assert hint(*hacked(rng), better="") == ""
