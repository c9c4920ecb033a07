"""The known cheats as mutations: what each leaves as it was, and what it does to it."""

from dataclasses import replace

import numpy as np
import pytest
from gymnasium.spaces import Box, Discrete
from numpy.random import default_rng

from harness_plugins.audit.search.moves import moves_in
from harness_plugins.audit.search.mutations import Pairs, mutations_of

HORIZON, COUNT = 30, 400
MOVES = {"numbers": moves_in(Box(-1.0, 1.0, (2,))), "choices": moves_in(Discrete(4))}
MUTATIONS = {kind: {it.__name__: it for it in mutations_of(moves)} for kind, moves in MOVES.items()}


def pairs_of(kind="numbers", length=12, second_length=7):
    """Parents whose actions all differ, so that a child tells where each of its actions comes from."""
    rng, moves = default_rng(0), MOVES[kind]
    first, second = moves.white(rng, COUNT, HORIZON), moves.white(rng, COUNT, HORIZON)
    return Pairs(moves, default_rng(1), first, np.full(COUNT, length), second, np.full(COUNT, second_length))


def mutated(name, pairs, kind="numbers"):
    """Children of a mutation."""
    return MUTATIONS[kind][name](replace(pairs, rng=default_rng(1)))


@pytest.mark.parametrize(("kind", "name"), [(kind, name) for kind, of in MUTATIONS.items() for name in of])
def test_children_are_actions_and_parents_stay(kind, name):
    """Of the same shape and kind and inside the bounds; the same generator brings the same children."""
    pairs = pairs_of(kind)
    before = pairs.first.copy(), pairs.second.copy()
    child, (low, high) = mutated(name, pairs, kind), (-1, 1) if kind == "numbers" else (0, 3)
    assert (child.shape, child.dtype) == (pairs.first.shape, pairs.first.dtype)
    assert low <= child.min() <= child.max() <= high
    assert np.array_equal(before, (pairs.first, pairs.second))
    assert np.array_equal(child, mutated(name, pairs, kind))
    assert (child != pairs.first).any(axis=tuple(range(1, child.ndim))).mean() > 0.3


@pytest.mark.parametrize("name", MUTATIONS["numbers"])
@pytest.mark.parametrize("length", [1, HORIZON])
def test_the_shortest_and_the_longest_parents_have_children(name, length):
    """An episode of one step, and one that lasts as long as can be."""
    assert np.isfinite(mutated(name, pairs_of(length=length, second_length=length))).all()


def test_stopping_keeps_what_was_before():
    """Up to some step before the end the child is its parent, and then does one thing."""
    pairs = pairs_of()
    child = mutated("stop_before_the_end", pairs)
    same = (child == pairs.first).all(axis=2)
    begin = np.where(same.all(axis=1), HORIZON, same.argmin(axis=1))
    assert (begin <= 12).all()
    assert all(np.ptp(child[k, step + 1 :], axis=0).max() == 0.0 for k, step in enumerate(begin))


def test_a_finish_at_the_end_ends_with_the_other():
    """A child ends as the other parent's episode did; what was before is the first parent's."""
    pairs = pairs_of()
    child = mutated("finish_at_the_end", pairs)
    assert np.array_equal(child[:, -1], pairs.second[:, 6])
    assert np.array_equal(child[:, : HORIZON - 7], pairs.first[:, : HORIZON - 7])


@pytest.mark.parametrize("name", ["wait", "repeat", "back_and_forth"])
def test_what_is_put_in_delays_the_rest(name):
    """Some children end their parent's episode in the very last step; some just do not."""
    pairs = pairs_of()
    assert ((mutated(name, pairs) == pairs.first[:, [11]]).all(axis=2).mean(axis=0)[-2:] > 0.05).all()


def test_back_and_forth_comes_back():
    """Where an action is a step on a line, the child is never further from its parent's way than the window is wide."""
    ones, length = np.ones((COUNT, HORIZON, 2), np.float32), np.full(COUNT, 12)
    child = mutated("back_and_forth", Pairs(MOVES["numbers"], default_rng(1), ones, length, 0.0 * ones, length))
    assert set(np.unique(child)) == {-1.0, 1.0}
    assert (np.cumsum(child, axis=1) >= 0.0).all()


@pytest.mark.parametrize("name", ["stretch", "slow_down_from"])
def test_slowing_down_goes_as_far(name):
    """Where an action is a step on a line, a slower child gets no further, and often nearly as far."""
    pairs = pairs_of()
    pairs.first[:] = 0.5 * (np.arange(HORIZON) < 12)[:, None]
    assert (np.abs(mutated(name, pairs).sum(axis=1)[:, 0] - 6.0) < 0.7).mean() > 0.3


def test_what_is_left_out_comes_sooner():
    """A child is its parent without a window: all of its actions are in order."""
    pairs = pairs_of()
    child = mutated("leave_out", pairs)
    for k in range(20):
        came = [int(np.flatnonzero((pairs.first[k] == it).all(axis=1))[0]) for it in child[k]]
        steps = np.diff(came)
        assert ((steps == 1) | (steps == 0)).sum() >= HORIZON - 2
        assert (steps >= 0).all()
