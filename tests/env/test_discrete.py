"""Discrete actions: one choice of many."""

import gymnasium
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from harness.task import ReachTask
from harness_plugins.tasks.unity import Arp2021
from tests.registered import UNITY_ARM as ARM


def test_spaces_are_discrete(make):
    """The FD100's joints give 13 choices: stay, and each of them backwards or forwards."""
    env = make(3, ReachTask(action="discrete"))
    assert env.single_action_space == gymnasium.spaces.Discrete(13)
    assert env.action_space == gymnasium.spaces.MultiDiscrete([13] * 3)
    assert env.action_space.sample() in env.action_space


@pytest.mark.parametrize("choice", range(13))
def test_choice_is_the_continuous_action_that_it_stands_for(make, choice):
    """2 i + 1 and 2 i + 2 are minus and plus one of action i, bit for bit; 0 stays."""
    discrete, continuous = make(1, ReachTask(action="discrete")), make(1, ReachTask())
    action = np.zeros((1, 6), np.float32)
    if choice:
        action[0, (choice - 1) // 2] = -1.0 if choice % 2 else 1.0
    for env in (discrete, continuous):
        env.reset(seed=0)
    for _ in range(3):
        one, other = discrete.step(np.array([choice])), continuous.step(action)
        assert_array_equal(one[0], other[0])
        assert_array_equal(one[1], other[1])


def test_meaning_of_the_choice_is_recorded(make, recorded):
    """The trace holds the action that was chosen, as long as that of the continuous mode."""
    trace = recorded(make(2, ReachTask(action="discrete")), lambda env: env.step(np.array([0, 4])))
    assert_array_equal(trace["action"][2:], [[0.0] * 6, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]])


def test_choice_of_positions_counts_from_where_the_arm_is(make):
    """Of joints that are set one goes on by a tenth of half its range, once a decision; the others stay."""
    env = make(1, Arp2021(action="discrete:action=set-joints"), robot=ARM, seed=0)
    for count in range(1, 4):
        env.step(np.array([2]))
        expected = ARM.home + count * 0.1 * ARM.upper * (np.arange(5) == 0)
        assert_allclose(env.simulation.read().qpos, [expected], atol=1e-12)


def test_single_env_takes_a_whole_number():
    """Python's own, or numpy's."""
    env = gymnasium.make("harness/Reach-v0", simulator="kinematic", task="arp-2021:action=discrete", reward="baseline")
    assert env.action_space == gymnasium.spaces.Discrete(11)
    env.reset(seed=0)
    first, *_ = env.step(3)
    env.reset(seed=0)
    assert_array_equal(env.step(np.int64(3))[0], first)
    env.close()


def test_choices_are_left_alone(make):
    """The caller's array stays as it is."""
    env = make(2, ReachTask(action="discrete"), seed=0)
    choices = np.array([1, 12])
    env.step(choices)
    assert_array_equal(choices, [1, 12])
