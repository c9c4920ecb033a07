"""The known cheats as mutations: what each leaves as it was, and what it does to it."""

import numpy as np
import pytest

from harness_plugins.audit.search.moves import Choices, Reals
from harness_plugins.audit.search.mutations import (
    ANYWHERE,
    OF_NUMBERS,
    Pairs,
    back_and_forth,
    finish_at_the_end,
    leave_out,
    mutations_of,
    repeat,
    slow_down_from,
    stop_before_the_end,
    stretch,
    wait,
)

HORIZON, COUNT = 30, 400
NUMBERS, CHOICES = Reals(np.zeros(2), np.ones(2)), Choices(4)


def pairs_of(moves, length=12, second_length=7):
    """Parents whose actions all differ, so that a child tells where each of its actions comes from."""
    rng = np.random.default_rng(0)
    first, second = moves.white(rng, COUNT, HORIZON), moves.white(rng, COUNT, HORIZON)
    return Pairs(moves, first, np.full(COUNT, length), second, np.full(COUNT, second_length))


def mutated(mutation, pairs, seed=1):
    """Children of a mutation."""
    return mutation(pairs, np.random.default_rng(seed))


@pytest.mark.parametrize("name", [*ANYWHERE, *OF_NUMBERS])
@pytest.mark.parametrize("moves", [NUMBERS, CHOICES], ids=["numbers", "choices"])
def test_children_are_actions_and_parents_stay(name, moves):
    """Of the same shape and kind and inside the bounds; the same generator brings the same children."""
    mutation = next((it for it in mutations_of(moves) if it.__name__ == name), None)
    if mutation is None:
        assert name in OF_NUMBERS
        return
    pairs = pairs_of(moves)
    before = pairs.first.copy(), pairs.second.copy()
    child = mutated(mutation, pairs)
    assert (child.shape, child.dtype) == (pairs.first.shape, pairs.first.dtype)
    assert child.min() >= (-1 if moves is NUMBERS else 0)
    assert child.max() <= (1 if moves is NUMBERS else 3)
    assert np.array_equal(before[0], pairs.first)
    assert np.array_equal(before[1], pairs.second)
    assert np.array_equal(child, mutated(mutation, pairs))
    assert (child != pairs.first).any(axis=tuple(range(1, child.ndim))).mean() > 0.3


@pytest.mark.parametrize("name", [*ANYWHERE, *OF_NUMBERS])
@pytest.mark.parametrize("length", [1, HORIZON])
def test_the_shortest_and_the_longest_parents_have_children(name, length):
    """An episode of one step, and one that lasts as long as can be."""
    mutation = {**ANYWHERE, **OF_NUMBERS}[name]
    assert np.isfinite(mutated(mutation, pairs_of(NUMBERS, length, length))).all()


def test_stopping_keeps_what_was_before():
    """Up to some step before the end the child is its parent, and then does one thing."""
    pairs = pairs_of(NUMBERS)
    child = mutated(stop_before_the_end, pairs)
    same = (child == pairs.first).all(axis=2)
    begin = np.where(same.all(axis=1), HORIZON, same.argmin(axis=1))
    assert (begin <= 12).all()
    for k, step in enumerate(begin):
        assert np.ptp(child[k, step + 1 :], axis=0).max() == 0.0


def test_a_finish_at_the_end_ends_with_the_other():
    """A child ends as the other parent's episode did; what was before is the first parent's."""
    pairs = pairs_of(NUMBERS)
    child = mutated(finish_at_the_end, pairs)
    assert np.array_equal(child[:, -1], pairs.second[:, 6])
    assert np.array_equal(child[:, : HORIZON - 7], pairs.first[:, : HORIZON - 7])


@pytest.mark.parametrize("mutation", [wait, repeat, back_and_forth])
def test_what_is_put_in_delays_the_rest(mutation):
    """Some children end their parent's episode in the very last step; some just do not."""
    pairs = pairs_of(NUMBERS)
    child = mutated(mutation, pairs)
    arrives = [(child[:, step] == pairs.first[:, 11]).all(axis=1) for step in range(HORIZON)]
    assert arrives[HORIZON - 1].mean() > 0.05
    assert arrives[HORIZON - 2].mean() > 0.05


def test_back_and_forth_comes_back():
    """Where an action is a step on a line, the child is never further from its parent's way than the window is wide."""
    ones, length = np.ones((COUNT, HORIZON, 2), np.float32), np.full(COUNT, 12)
    forth = Pairs(NUMBERS, ones, length, 0.0 * ones, length)
    child = mutated(back_and_forth, forth)
    assert set(np.unique(child)) == {-1.0, 1.0}
    assert (np.cumsum(child, axis=1) >= 0.0).all()


def test_slowing_down_goes_as_far():
    """Where an action is a step on a line, a slower child gets no further, and often nearly as far."""
    for mutation in (stretch, slow_down_from):
        pairs = pairs_of(NUMBERS)
        pairs.first[:, 12:] = 0.0
        pairs.first[:, :12] = 0.5
        way = mutated(mutation, pairs).sum(axis=1)[:, 0]
        slower = way[np.abs(way - 6.0) < 0.7]
        assert len(slower) > 0.3 * COUNT


def test_what_is_left_out_comes_sooner():
    """A child is its parent without a window: all of its actions are in order."""
    pairs = pairs_of(NUMBERS)
    child = mutated(leave_out, pairs)
    for k in range(20):
        came = [int(np.flatnonzero((pairs.first[k] == it).all(axis=1))[0]) for it in child[k]]
        steps = np.diff(came)
        assert ((steps == 1) | (steps == 0)).sum() >= HORIZON - 2
        assert (steps >= 0).all()
