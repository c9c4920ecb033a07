"""What a search keeps of all that it played, against a look at all of it at once."""

import numpy as np
import pytest
from numpy.random import default_rng

from harness_plugins.audit.search.kept import Kept
from harness_plugins.audit.search.world import Outcomes

HORIZON = 40


def outcomes_of(rng, count):
    """Episodes drawn at random: a third of them succeed."""
    success, time = rng.random(count) < 0.3, rng.integers(1, HORIZON + 1, count)
    steps = np.where(success, time, HORIZON)
    return Outcomes(
        steps=steps,
        paid=rng.normal(size=count).round(3),
        discounted=rng.normal(size=count).round(3),
        success=success,
        time=steps,
        share=np.where(success, 1.0 / steps, 0.0),
        near=np.full(count, np.nan),
    )


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("count", [3, 60])
def test_the_three_are_those_of_all_episodes(seed, count):
    """The best failure, the best success, the best of those as fast as the fastest; both sums, in any order."""
    rng = default_rng(seed)
    kept, rows, parts = Kept([5, 9], HORIZON), [], []
    for _ in range(4):
        rows.append(rng.integers(2, size=count))
        parts.append(outcomes_of(rng, count))
        kept.add(rows[-1], [np.zeros((HORIZON, 1))] * count, parts[-1], "search")
    at = np.concatenate(rows)
    success, time = (np.concatenate([getattr(it, name) for it in parts]) for name in ("success", "time"))
    for of, name in ((kept.plain, "paid"), (kept.discounted, "discounted")):
        pays = np.concatenate([getattr(it, name) for it in parts])
        for row in (0, 1):
            three = of[row].three(0.0, False)
            failures, done = (at == row) & ~success, (at == row) & success
            assert ("failure" not in three) == (not failures.any())
            if failures.any():
                assert getattr(three["failure"], name) == pays[failures].max()
            assert ("success" not in three) == (not done.any())
            if done.any():
                assert getattr(three["success"], name) == pays[done].max()
                fast = done & (time <= 1.1 * time[done].min())
                assert getattr(three["fastest"], name) == pays[fast].max()


def test_a_trifle_more_is_no_reason_to_be_slow():
    """A success that is paid as well but for a hundredth, and comes sooner, stands for the best; but not of a table."""
    kept = Kept([0], HORIZON)
    time = np.array([10, 30, 40])
    kept.add(
        np.zeros(3, int),
        [np.zeros((HORIZON, 1))] * 3,
        Outcomes(time, *[np.array([5.0, 9.95, 10.0])] * 2, np.ones(3, bool), time, 1.0 / time, np.full(3, np.nan)),
        "search",
    )
    assert kept.plain[0].three(0.0)["success"].time == 30
    assert kept.plain[0].three(0.0, False)["success"].time == 40
    assert kept.plain[0].three(0.0)["fastest"].time == 10


def test_different_successes_are_counted_once():
    """By the actions up to the end; what lies behind it does not count."""
    kept = Kept([0], 3)
    actions = np.array([[1, 2, 3], [1, 2, 4], [1, 3, 4], [0, 0, 0]])
    steps, success = np.array([2, 2, 2, 3]), np.array([True, True, True, False])
    pays = np.zeros(4)
    for _ in range(2):
        kept.add(np.zeros(4, int), actions, Outcomes(steps, pays, pays, success, steps, pays, pays), "search")
    assert kept.successes == [2]


@pytest.mark.parametrize(
    ("failure", "time"), [(-1.0, 12), (9.9, 40)], ids=["failures are far behind", "a failure is nearly as well paid"]
)
def test_where_most_is_gained_soon_that_success_stands_for_the_best(failure, time):
    """Pay that saturates with time is no loop; but what stands for the best is paid more than failures are."""
    kept, times = Kept([0], HORIZON), np.array([4, 12, 40, 40])
    pays, success = np.array([5.0, 9.2, 10.0, failure]), np.array([True, True, True, False])
    outcomes = Outcomes(times, pays, pays, success, times, success / times, np.full(4, np.nan))
    kept.add(np.zeros(4, int), [np.zeros((HORIZON, 1))] * 4, outcomes, "search")
    assert kept.plain[0].three(4.0)["success"].time == time
