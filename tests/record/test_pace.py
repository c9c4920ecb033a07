"""How long the rest of a run takes."""

import itertools

import pytest
from hypothesis import given, strategies as st

from harness.record.pace import Begun, Pace, makespan, time_left, took

SECONDS = st.lists(st.floats(0.1, 100.0), max_size=6)


def played(running, waiting, at_once):
    """The same as `makespan`, in small steps of the clock."""
    left, now = list(running), 0.0
    queue = list(waiting)
    while left or queue:
        while queue and len(left) < at_once:
            left.append(queue.pop(0))
        passed = min(left)
        now += passed
        left = [seconds - passed for seconds in left if seconds > passed]
    return now


@given(st.lists(st.floats(0.1, 100.0), max_size=3), SECONDS, st.integers(3, 5))
def test_the_next_begins_as_soon_as_one_ends(running, waiting, at_once):
    """As if it were played."""
    assert makespan(running, waiting, at_once) == pytest.approx(played(running, waiting, at_once))


def test_nothing_is_known_before_a_step_was_measured(make_cell):
    """Neither of a cell that has begun nor of one that waits."""
    cell = make_cell(steps=100)
    assert time_left([], [Begun(cell, 0, None)], [cell], 2) is None


def test_a_kind_counts_by_its_own_cells(make_cell):
    """Each algorithm by what its cells took; one that was not seen yet as the mean of the others."""
    slow, fast = make_cell(steps=100), make_cell(steps=100, algorithm=_renamed(make_cell().algorithm, "fast"))
    unseen = make_cell(steps=100, algorithm=_renamed(make_cell().algorithm, "unseen"))
    ended = [took(slow, 10.0, 2.0), took(fast, 1.0, 4.0)]
    assert time_left(ended, [], [slow]) == pytest.approx(12.0)
    assert time_left(ended, [], [fast]) == pytest.approx(5.0)
    assert time_left(ended, [], [unseen]) == pytest.approx(5.5 + 3.0)


def test_a_cell_that_was_trained_is_still_evaluated(make_cell):
    """As long as the others were, less what has passed."""
    cell = make_cell(steps=100)
    ended = [took(cell, 10.0, 4.0)]
    assert time_left(ended, [Begun(cell, 100, 0.1, since=1.0)], []) == pytest.approx(3.0)
    assert time_left(ended, [Begun(cell, 100, 0.1, since=9.0)], []) == 0.0


def test_what_a_training_does_at_first_does_not_count(make_cell):
    """It acts at random until it learns, a hundred times as fast."""
    clock = itertools.chain([0.0], *([float(second)] for second in range(1, 100)))
    now = [0.0]
    cell = make_cell(steps=10_000)
    pace = Pace([cell], lambda: now[0])
    pace.start(cell)
    for second in clock:
        now[0] = second / 4.0
        pace.hear(cell, int(1000 + 100 * max(second / 4.0 - 0.5, 0.0)) if second else 0)
        if second / 4.0 >= 4.0:
            break
    assert pace.left == pytest.approx((10_000 - 1350) / 100, rel=0.01)


def test_a_failed_cell_says_nothing_of_the_others(make_cell):
    """However soon it failed."""
    cell, other = make_cell(steps=100), make_cell(steps=100, seed=1)
    pace = Pace([cell, other], lambda: 0.0)
    pace.start(cell)
    pace.end(cell, failed=True)
    assert pace.left is None


def _renamed(choice, label):
    return type(choice)(label, choice.params, label)
