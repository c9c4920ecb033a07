"""Whether what a search found is a knife's edge."""

import numpy as np
import pytest
from gymnasium.spaces import Box, Discrete

from harness_plugins.audit.search.behaviour import Behaviour, Three
from harness_plugins.audit.search.disturb import Acting, disturb, disturbed_actions, noise_curve, rested, strength_of
from harness_plugins.audit.search.finding import FAILING, FRAGILE, ROBUST
from harness_plugins.audit.search.judge import Case
from tests.plugins.audit.search.toy_worlds import EnvWorld, Graph, told


def _rng():
    return np.random.default_rng(0)


@pytest.mark.parametrize(("low", "high", "half"), [(-1.0, 1.0, 1.0), (-2.0, 6.0, 4.0), (-np.inf, np.inf, 1.0)])
def test_noise_is_a_share_of_half_the_range(low, high, half):
    """Of a box without bounds the range is taken for 2."""
    space, given = Box(low, high, (1,), np.float64), np.full((20_000, 1), 0.0 if low < -9 else (low + high) / 2)
    moved = disturbed_actions(space, given, 0.05, _rng()) - given
    assert moved.std() == pytest.approx(0.05 * half, rel=0.03)


def test_disturbed_actions_stay_in_the_box():
    """And have its type; without noise they stay as they are."""
    space, given = Box(-1.0, 1.0, (2,)), np.ones((50, 2), np.float32)
    moved = disturbed_actions(space, given, 0.05, _rng())
    assert (moved.dtype, space.low.min() <= moved.min(), moved.max()) == (np.float32, True, 1.0)
    assert (disturbed_actions(space, given, 0.0, _rng()) == given).all()


def test_of_choices_some_are_others():
    """With that chance, and never the same one; choices may begin at another number than 0."""
    space, given = Discrete(3, start=5), np.full(20_000, 6)
    moved = disturbed_actions(space, given, 0.05, _rng())
    assert (moved != given).mean() == pytest.approx(0.05, abs=0.005)
    assert {*moved.tolist()} == {5, 6, 7}


class _Line:
    """What `rested` asks of a world."""

    horizon, space = 4, Box(-1.0, 1.0, (2,))


def test_an_episode_that_ended_rests_until_the_horizon():
    """Zeros in a box, the last choice again."""
    assert rested(_Line, np.ones((2, 2))).tolist() == [[1, 1], [1, 1], [0, 0], [0, 0]]
    _Line.space = Discrete(3)
    assert rested(_Line, np.array([2, 1])).tolist() == [2, 1, 1, 1]


EDGE = [[(1, 0.0, False, False), (0, 0.0, True, True)], [(1, 1.0, False, False), (0, -100.0, False, True)]]
"""Choice 0 goes to a state that pays 1 for staying and costs 100 to leave by choice 1; at first that succeeds."""
BROAD = [[(1, 0.0, False, False), (0, 0.0, True, True)], [(1, 1.0, False, False), (1, 1.0, False, False)]]
"""The same, but there both choices pay."""


def _case(edges):
    world = EnvWorld(lambda: Graph(edges), told, horizon=50)
    failure = Behaviour(0, np.zeros(50, int), 49.0, 38.0, False, 50, 50, 0.0)
    success = Behaviour(0, np.ones(1, int), 0.0, 0.0, True, 1, 1, 1.0)
    return world, Case(Three(0, failure, success, success), FAILING, "failure", "success", 9.0, 2.0, 1.0)


@pytest.mark.parametrize(("edges", "word"), [(EDGE, FRAGILE), (BROAD, ROBUST)])
def test_what_one_other_choice_spoils_is_fragile(edges, word):
    """Among 49 choices with a chance of 0.05 each."""
    world, case = _case(edges)
    stood = strength_of(world, [(case, {}), (case, {})], _rng())
    assert (stood.word, stood.count, stood.stands) == (word, 2, 2 * (word == ROBUST))
    assert (stood.tempting > stood.task + case.margin) == (word == ROBUST)


def test_a_curve_begins_without_noise():
    """Then what was found was paid; the more noise, the less of it is left of a knife's edge."""
    world, case = _case(EDGE)
    curve = noise_curve(world, {"failure": case.three.failure}, {}, _rng())
    assert [of.noise for of in curve] == [0.0, 0.01, 0.05]
    assert curve[0].paid == 49.0 > curve[1].paid > curve[2].paid


def test_a_policy_acts_again():
    """From the starts that it is given; what it observes decides, whatever was done before."""
    world, case = _case(EDGE)
    asked = []
    outcomes = disturb(world, case.three.failure, 0.0, _rng(), Acting(lambda seen: asked.append(seen) or 1, [3, 4]))
    assert outcomes.success.all()
    assert len(asked) == 32
