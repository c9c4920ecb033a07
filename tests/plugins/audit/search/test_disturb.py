"""Whether what a search found is a knife's edge."""

from types import SimpleNamespace

import numpy as np
import pytest
from gymnasium.spaces import Box, Discrete
from numpy.random import default_rng

from harness_plugins.audit.search.behaviour import Behaviour
from harness_plugins.audit.search.disturb import disturb, noise_curve, strength_of
from harness_plugins.audit.search.judge import Case
from tests.plugins.audit.search.toy_worlds import EnvWorld, Graph, told


def rng():
    """The same one each time."""
    return default_rng(0)


def behaviour_of(actions, paid=0.0, success=False, time=50):
    """An episode of these actions."""
    steps = len(actions)
    return Behaviour(0, np.asarray(actions), paid, paid, success, steps, time, 1.0 * success)


def disturbed(space, actions, noise=0.05, horizon=None):
    """The actions of 32 disturbed episodes, as a world is given them."""
    taken, nothing = [], np.zeros(32)

    def play(starts, actions):
        taken.append(actions)
        return SimpleNamespace(paid=nothing, discounted=nothing, success=nothing)

    world = SimpleNamespace(space=space, horizon=horizon or len(actions), play=play)
    disturb(world, [(behaviour_of(actions), noise, None)], rng())
    return taken[0]


@pytest.mark.parametrize(("low", "high", "half"), [(-1.0, 1.0, 1.0), (-2.0, 6.0, 4.0), (-np.inf, np.inf, 1.0)])
def test_noise_is_a_share_of_half_the_range(low, high, half):
    """Of a box without bounds the range is taken for 2."""
    given = np.full((1_000, 1), 0.0 if low < -9 else (low + high) / 2)
    moved = disturbed(Box(low, high, (1,), np.float64), given) - given
    assert moved.std() == pytest.approx(0.05 * half, rel=0.03)


def test_disturbed_actions_stay_in_the_box():
    """And have its type; without noise they stay as they are."""
    space, given = Box(-1.0, 1.0, (2,)), np.ones((50, 2), np.float32)
    moved = disturbed(space, given)
    assert (moved.dtype, moved.min() >= -1.0, moved.max()) == (np.float32, True, 1.0)
    assert (disturbed(space, given, 0.0) == given).all()


def test_of_choices_some_are_others():
    """With that chance, and never the same one; choices may begin at another number than 0."""
    moved = disturbed(Discrete(3, start=5), np.full(1_000, 6))
    assert (moved != 6).mean() == pytest.approx(0.05, abs=0.005)
    assert {*moved.ravel().tolist()} == {5, 6, 7}


@pytest.mark.parametrize(
    ("space", "given", "rested"),
    [
        (Box(-1.0, 1.0, (2,)), np.ones((2, 2)), [[1, 1], [1, 1], [0, 0], [0, 0]]),
        (Discrete(3), np.array([2, 1]), [2, 1, 1, 1]),
    ],
)
def test_an_episode_that_ended_rests_until_the_horizon(space, given, rested):
    """Zeros in a box, the last choice again."""
    assert disturbed(space, given, 0.0, 4)[0].tolist() == rested


EDGE = [[(1, 0.0, False, False), (0, 0.0, True, True)], [(1, 1.0, False, False), (0, -100.0, False, True)]]
"""Choice 0 goes to a state that pays 1 for staying and costs 100 to leave by choice 1; at first that succeeds."""
BROAD = [EDGE[0], [(1, 1.0, False, False)] * 2]
"""The same, but there both choices pay."""


def case_of(edges):
    """A world, and the case of its alarm."""
    world = EnvWorld(lambda: Graph(edges), told, horizon=50)
    failure, success = behaviour_of(np.zeros(50, int), 49.0), behaviour_of(np.ones(1, int), 0.0, True, 1)
    return world, Case(
        {"failure": failure, "success": success}, "PAYS FOR FAILING", "failure", "success", 9.0, 2.0, 1.0
    )


@pytest.mark.parametrize(("edges", "word"), [(EDGE, "FRAGILE"), (BROAD, "ROBUST")])
def test_what_one_other_choice_spoils_is_fragile(edges, word):
    """Among 49 choices with a chance of 0.05 each."""
    world, case = case_of(edges)
    found, stands, (tempting, task) = strength_of(world, [(case, {}), (case, {})], rng())
    assert (found, stands) == (word, 2 * (word == "ROBUST"))
    assert (tempting > task + case.margin) == (word == "ROBUST")


def test_a_curve_begins_without_noise():
    """Then what was found was paid; the more noise, the less of it is left of a knife's edge."""
    world, case = case_of(EDGE)
    curve = noise_curve(world, {"failure": case.three["failure"]}, {}, rng())
    assert [of.noise for of in curve] == [0.0, 0.01, 0.05]
    assert curve[0].paid == 49.0 > curve[1].paid > curve[2].paid


def test_a_policy_acts_again():
    """From the starts that it is given; what it observes decides, whatever was done before."""
    world, case = case_of(EDGE)
    asked = []
    acting = (lambda seen: asked.append(seen) or 1, [3, 4])
    ((_, _, success),) = disturb(world, [(case.three["failure"], 0.0, acting)], rng())
    assert success.all()
    assert len(asked) == 32


def test_behaviours_are_disturbed_as_each_alone_would_be():
    """Sequences side by side, policies by themselves: the noise is drawn in the order in which they are asked."""
    world, case = case_of(EDGE)
    acting, one = (lambda seen: 0, [3, 4]), case.three["failure"]
    asked, drawn = [(one, 0.05, None), (one, 0.05, acting), (one, 0.01, None)], rng()
    assert (disturb(world, asked, rng()) == np.concatenate([disturb(world, [it], drawn) for it in asked])).all()
