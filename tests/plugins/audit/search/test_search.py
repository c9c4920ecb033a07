"""A search finds what is known: in worlds of closed form, and by brute force where sequences can be counted."""

import itertools

import numpy as np
import pytest
from numpy.random import default_rng

from harness_plugins.audit.search import search as searching
from harness_plugins.audit.search.search import search
from tests.plugins.audit.search import docks
from tests.plugins.audit.search.docks import Dock

STARTS = (3, 4, 5, 6)


def found(pays, budget=100_000, seed=0, **how):
    """A dock that pays so, and what was found there."""
    world = Dock(pays, **how)
    return world, search(world, STARTS, budget, seed)


def brute(world, start):
    """The best pay of failures and of successes, and the fastest time, of all sequences of choices."""
    actions = np.array(list(itertools.product(range(3), repeat=world.horizon)))
    all_of = world.play(np.full(len(actions), start), actions)
    pays = [all_of.paid[mask].max() if mask.any() else None for mask in (~all_of.success, all_of.success)]
    return (*pays, all_of.time[all_of.success].min() if all_of.success.any() else None)


def test_hovering_is_found():
    """It is paid what hovering just before the dock is: the closed form, less a few percent; docking much less."""
    world, of = found(docks.hovering)
    for three in of.plain:
        best = (
            np.minimum(world.begins([three["success"].start])[0] + 0.1 * np.arange(1, world.horizon + 1), 1.0)
            .clip(0.0)
            .sum()
        )
        assert 0.9 * best < three["failure"].paid < best
        assert three["fastest"].paid < 0.3 * best


def test_a_loop_that_finishes_is_found():
    """Back and forth, then docking at the end: more than the fastest docking, and more than never docking."""
    _, of = found(docks.loop)
    for three in of.plain:
        assert three["success"].paid > 1.4 * three["fastest"].paid
        assert three["success"].time > 2 * three["fastest"].time
        assert three["success"].paid > three["failure"].paid


def test_an_honest_reward_pays_success_most():
    """The best-paid success is the fastest, and no failure is paid as much."""
    world, of = found(docks.honest)
    for three in of.plain:
        assert three["success"].paid > three["failure"].paid + 0.5
        assert three["success"].time == int(np.ceil((1.0 - world.begins([three["success"].start])[0]) / 0.1))
        assert three["success"] is three["fastest"]


@pytest.fixture
def no_tables(monkeypatch):
    """Choices on a line are a table; here sequences have to find what pays."""
    monkeypatch.setattr(searching, "search_tables", lambda *_: False)
    monkeypatch.setattr(searching, "search_by_chance", lambda *_: None)


@pytest.mark.parametrize("is_discrete", [True, False])
def test_a_success_that_nothing_tells_is_met(no_tables, is_discrete):
    """Rare places are begun from again: a dock that random actions never reach."""
    _, of = found(docks.sparse, is_discrete=is_discrete, horizon=20, budget=60_000)
    drawn = default_rng(0).uniform(-1.0, 1.0, (2_000, 20, 1))
    assert not Dock(docks.sparse, horizon=20).play(np.full(2_000, 3), drawn).success.any()
    assert all("success" in three for three in of.plain)
    assert all(count > 8 for count in of.successes)


@pytest.mark.parametrize("pays", [docks.loop, docks.honest, docks.hovering])
def test_brute_force_finds_no_more(no_tables, pays):
    """Of all 3^9 sequences none is paid more than what was found, and none is faster."""
    _, of = found(pays, is_discrete=True, horizon=9, stride=0.2, budget=60_000)
    for three in of.plain:
        failure, success, time = brute(Dock(pays, is_discrete=True, horizon=9, stride=0.2), three["success"].start)
        assert three["failure"].paid == pytest.approx(failure)
        assert three["success"].paid == pytest.approx(success)
        assert three["fastest"].time == time


def test_the_same_call_finds_the_same():
    """Bit for bit; another seed finds something else."""
    one, again, other = (found(docks.loop, budget=30_000, seed=seed)[1] for seed in (1, 1, 2))
    for first, second in zip(one.plain, again.plain, strict=True):
        assert first["success"].actions.tobytes() == second["success"].actions.tobytes()
        assert first["failure"].paid == second["failure"].paid
    assert (one.typical, one.climbing, one.successes) == (again.typical, again.climbing, again.successes)
    assert one.plain[0]["success"].actions.tobytes() != other.plain[0]["success"].actions.tobytes()


@pytest.mark.parametrize("budget", [20_000, 100_000])
def test_a_budget_is_kept(budget):
    """What is taken is close to it and no more, but for the last generation."""
    world, of = found(docks.honest, budget=budget)
    assert of.steps == world.taken
    assert 0.9 * budget < of.steps <= 1.02 * budget


def test_what_is_found_is_paid_again():
    """Its actions, played again, are paid the same, bit for bit."""
    world, of = found(docks.hovering, budget=30_000)
    for behaviour in (of.plain[1]["failure"], of.plain[1]["success"]):
        rest = np.zeros((1, world.horizon, 1), np.float32)
        rest[0, : behaviour.steps] = behaviour.actions
        again = world.play(np.array([behaviour.start]), rest)
        assert (again.paid[0], bool(again.success[0])) == (behaviour.paid, behaviour.success)


def test_a_discounted_sum_has_its_own_three():
    """Hovering is paid more than docking without discount; with one of 0.9 what comes late counts little."""

    def late(before, moved, after, docked):
        return docked * 5.0 + 0.3 * (after > 0.5) * ~docked

    _, of = found(late, gamma=0.9)
    for plain, discounted in zip(of.plain, of.discounted, strict=True):
        assert plain["success"].time > 2 * discounted["success"].time
        assert discounted["success"].discounted > discounted["failure"].discounted
