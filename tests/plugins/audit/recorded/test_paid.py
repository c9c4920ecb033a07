"""Two rewards beside one another in the steps of a recording."""

from io import StringIO
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st
from rich.console import Console

from harness.log import Failed, LogFacts, in_memory
from harness_plugins.audit.recorded.pair import paid_in, pairs_in
from harness_plugins.audit.recorded.pair_grid import pair_grid

NUMBERS = st.lists(st.integers(-20, 20), min_size=2, max_size=12)
ZERO = pytest.approx(0.0, abs=1e-7)


def log_of(unit="step", failed=(), **columns):
    """Of one training."""
    facts = LogFacts(path=Path("log"), format="made", unit=unit, failed=failed)
    return in_memory(facts, {name.replace("__", "/"): np.asarray(values) for name, values in columns.items()})


def pair_of(*both):
    """Both rewards in some recordings, of each of which every step is an episode."""
    logs = [
        log_of(
            reward__one=np.asarray(one, float), reward__other=np.asarray(other, float), terminated=[True] * len(one),
            episode=np.arange(len(one)),
        )
        for one, other in both
    ]  # fmt: skip
    ((pair,), _) = pairs_in([(str(number), log) for number, log in enumerate(logs)], ("one", "other"))
    return pair


def apart(one, other):
    """How far apart they are in one recording."""
    (found,) = pair_of((one, other)).each
    return found


@given(st.lists(st.tuples(st.integers(-9, 9), st.integers(-9, 9)), min_size=2, max_size=12))
def test_order_is_what_counting_pairs_gives(values):
    """Ties of either reward are left out of the share, and told."""
    one, other = np.array(values).T
    pairs = [(a, b) for a, b in combinations(range(len(one)), 2) if one[a] != one[b] and other[a] != other[b]]
    opposite = sum((one[a] < one[b]) != (other[a] < other[b]) for a, b in pairs)
    order = apart(one, other)
    assert order.told_apart == pytest.approx(len(pairs) / (len(one) * (len(one) - 1) / 2))
    assert order.discordant == (pytest.approx(opposite / len(pairs)) if pairs else None)


@given(NUMBERS, st.sampled_from([0.5, 3.0]), st.integers(-5, 5))
def test_scale_and_offset_are_no_distance(values, scale, offset):
    """Neither in steps nor in returns, nor in the order of episodes."""
    found = apart(values, scale * np.array(values) + offset)
    assert (found.steps, found.returns, found.discordant or 0.0) == (ZERO, ZERO, 0.0)


@given(NUMBERS, st.data())
def test_distance_is_symmetric_and_from_0_to_1(values, data):
    """As is the share of episodes in another order."""
    others = data.draw(st.lists(st.integers(-20, 20), min_size=len(values), max_size=len(values)))
    there = apart(values, others)
    assert there == apart(others, values)
    assert there.steps is None or 0.0 <= there.steps <= 1.0


@pytest.mark.parametrize(
    ("one", "other", "found"),
    [
        ([1, 2, 4], [-1, -2, -4], (pytest.approx(1.0), pytest.approx(1.0), 1.0, 1.0)),
        ([1, 2, 3], [5, 5, 5], (None, None, None, 0.0)),
        ([1], [2], (None, None, None, None)),
        ([0.1 + 0.2, 0.3], [1, 2], (None, None, None, 0.0)),
    ],
    ids=["opposite", "a constant tells nothing apart", "one episode has no order", "0.1 + 0.2 is 0.3"],
)
def test_distances_by_hand(one, other, found):
    """In steps, in returns, the share in the opposite order, and that of pairs that both tell apart."""
    assert tuple(vars(apart(one, other)).values())[1:4] == found[1:]


def test_steps_and_episodes_of_a_log_are_paid():
    """Of envs that take turns; an episode that has not ended is left out, and its steps are not."""
    paid = paid_in(log_of(
        env=[0, 1, 0, 1, 0, 1],
        episode=[0, 0, 0, 0, 1, 0],
        terminated=[False, False, True, False, False, False],
        truncated=[False, False, False, False, False, True],
        reward__a=[1.0, 10.0, 2.0, 20.0, 4.0, 30.0],
    ))  # fmt: skip
    assert (paid.returns["a"].tolist(), paid.steps["a"].tolist()) == ([3.0, 60.0], [1.0, 10.0, 2.0, 20.0, 4.0, 30.0])


def test_start_of_an_episode_is_no_step():
    """It is paid nothing, and is not compared."""
    starts, ends = [True, False, False, True, False, False], [False, False, True, False, False, True]
    paid = {"reward__a": [99.0, 1.0, 2.0, 99.0, 3.0, 5.0], "reward__b": [-99.0, 2.0, 4.0, -99.0, 6.0, 10.0]}
    log = log_of(start=starts, terminated=ends, episode=[0, 0, 0, 1, 1, 1], **paid)
    ((pair,), _) = pairs_in([("some", log)], ("a", "b"))
    assert pair.steps.value == ZERO


def test_rows_of_episodes_are_compared_by_episodes_alone():
    """There are no steps to compare."""
    log = log_of(unit="episode", reward__a=[1.0, 2.0, 4.0], reward__b=[2.0, 4.0, 8.0])
    ((pair,), _) = pairs_in([("some", log)], ("a", "b"))
    assert (pair.steps.value, pair.returns.value, pair.discordant.value) == (None, ZERO, 0.0)


def test_reward_that_was_given_up_says_why():
    """It is known in no step then."""
    failed = (Failed("reward/a", "it broke"),)
    paid = paid_in(log_of(failed=failed, terminated=[True, True], reward__a=[1.0, np.nan], reward__b=[1.0, 2.0]))
    assert (paid.unknown, set(paid.returns)) == ({"a": "given up: it broke"}, {"b"})


def test_interval_of_a_distance_stays_between_0_and_1():
    """Student's alone would not. Where a distance is not defined it does not count."""
    same, unlike = ([1, 2, 3], [1, 2, 3]), ([1, 2, 3], [1, 3, 3])
    mean = pair_of(same, unlike, ([1, 2], [5, 5]), same).steps
    assert (mean.low, mean.seeds) == (0.0, 3)
    assert mean.high > mean.value > 0.0


SOME, NONE = ([1, 2, 3, 3], [3, 1, 2, 2]), ([1, 2], [5, 5])


@pytest.mark.parametrize(
    ("both", "told"),
    [
        ([SOME] * 2, "distance by steps 0.845 of what both pay for the same steps distance by episodes 0.845 of"),
        ([SOME] * 2, "opposite order 60.0% of the pairs of episodes that both tell apart; these are 83% of all pairs"),
        ([NONE], "distance by steps n/a one of the two pays every step the same, or no steps were kept"),
        ([SOME, NONE, SOME], "for the same steps; defined in 2 of 3"),
    ],
)
def test_numbers_stand_beside_what_they_mean(both, told):
    """Below three there is no interval; what is not defined says why, and in how many it is."""
    text = StringIO()
    Console(file=text, width=200).print(pair_grid(pair_of(*both)))
    assert told in " ".join(text.getvalue().split())
