"""Rewards of an arm as functions of observations."""

import itertools

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.random import default_rng

import harness
from harness import load_registry
from harness.env.vector_env import ReachVectorEnv
from harness.registry.choice import choose
from harness.reward import ObservedReward
from harness.score.places import parse_places
from harness_plugins.kit import IdealSimulator

POSITIONS = parse_places("end_effector=0:3,target=3:6,renewed=3:6")
ALONE = parse_places("distance=0:1,renewed=1:2")


class Distance:
    """Pays the baseline's gain: the distance at the begin less that after the step."""

    def initial_carry(self, begin_distance):
        """Nothing."""
        return ()

    def __call__(self, carry, sample):
        """Bd - d."""
        return carry, sample.begin_distance - sample.distance


def seen(x, target=0.0):
    """An end effector and a target on one axis."""
    return np.array([x, 0, 0, target, 0, 0], np.float64)


@pytest.mark.parametrize("name", ["baseline", "arp", "aarp", "relative", "dense"])
def test_it_pays_what_the_task_pays(name):
    """The same arm in the same task, whose distance is all that it is told."""
    registry = load_registry()
    reward = choose(registry, "rewards", name).build(registry, "rewards")
    task = choose(registry, "tasks", "fd100-reach:horizon=30").build(registry, "tasks")
    env = ReachVectorEnv(IdealSimulator(), harness.load_robot("fd100", registry), task, reward, 1)
    pays, rng = ObservedReward(reward, parse_places("distance=0:1")), default_rng(0)
    before = env.reset(seed=0)[1]["distance"]
    pays.reset()
    for _ in range(100):
        _, _, terminated, truncated, infos = env.step(rng.uniform(-1, 1, (1, 6)).astype(np.float32))
        after = infos["distance"]
        paid = pays(before, None, after, {"terminated": bool(terminated[0])})
        assert paid == pytest.approx(infos["reward_shaped"][0], abs=1e-12)
        before = after
        if terminated[0] or truncated[0]:
            before = env.episodes.distance.copy()
            pays.reset()


def test_each_step_of_a_decision_pays():
    """The arm is taken to be where it is seen next."""
    assert ObservedReward(Distance(), POSITIONS, 5)(seen(1.0), None, seen(0.5), {}) == pytest.approx(2.5)


def test_a_step_that_terminates_pays_once():
    """The episode ends there."""
    assert ObservedReward(Distance(), POSITIONS, 5)(seen(1.0), None, seen(0.5), {"terminated": True}) == 0.5


def test_a_new_target_begins_distances_anew():
    """The step pays by the old target, the next ones by the new."""
    pays = ObservedReward(Distance(), POSITIONS)
    assert pays(seen(1.0), None, seen(0.1, 3.0), {}) == pytest.approx(0.9)
    assert pays(seen(0.1, 3.0), None, seen(1.0, 3.0), {}) == pytest.approx(0.9)


def test_a_distance_alone_counts_a_touched_target_as_reached_wholly():
    """How close the arm came is not observed."""
    assert ObservedReward(Distance(), ALONE)(np.array([0.4, 0.0]), None, np.array([2.0, 1.0]), {}) == pytest.approx(0.4)


@given(st.lists(st.floats(0.0, 10.0), min_size=2, max_size=8))
def test_an_episode_is_forgotten(distances):
    """After a reset the same steps pay the same."""
    registry = load_registry()
    pays = ObservedReward(choose(registry, "rewards", "aarp").build(registry, "rewards"), parse_places("distance=0:1"))

    def play():
        pays.reset()
        rows = [np.array([distance]) for distance in distances]
        return [pays(one, None, other, {}) for one, other in itertools.pairwise(rows)]

    assert play() == play()
