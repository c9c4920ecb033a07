"""Gymnasium's rules: spaces, checkers, what belongs to the caller."""

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.testing import assert_array_equal

import harness
from harness.env.vector_env import ReachVectorEnv
from harness.task import ReachTask
from tests.refusals import refused

Call = Callable[..., Any]
NAMES = {"simulator": "mujoco", "task": "fd100-reach:horizon=20", "reward": "arp:k2=2"}


def test_make_vec_makes_a_batch():
    """`gymnasium.make_vec` gives our vector env, of as many arms as asked for."""
    envs = gymnasium.make_vec("harness/Reach-v0", num_envs=3, **NAMES)
    assert isinstance(envs.unwrapped, ReachVectorEnv)
    observations, _ = envs.reset(seed=0)
    assert observations.shape == (3, 28)
    envs.close()


def test_spaces_of_a_batch(make):
    """Observation and action spaces are the single ones with a leading num_envs axis; actions fill [-1, 1]."""
    env = make(3)
    assert env.observation_space.shape == (3, *env.single_observation_space.shape)
    assert env.action_space.shape == (3, 6)
    assert_array_equal(env.single_action_space.low, -1.0)
    assert_array_equal(env.single_action_space.high, 1.0)


def test_next_step_autoreset_is_refused(make):
    """The autoreset mode that is not offered is a usage error that names the two that are."""
    with refused("SAME_STEP or DISABLED"):
        make(autoreset_mode=AutoresetMode.NEXT_STEP)


def test_no_envs_are_refused():
    """A batch of no envs is a usage error."""
    with refused("num_envs=0"):
        harness.make_env(num_envs=0)


def test_observations_are_in_their_space(make, wander):
    """Whatever the actions, every observation of every episode is within the bounds, in float32."""
    env = make(4, ReachTask(horizon=30))
    assert env.reset(seed=0)[0] in env.observation_space
    for observations, *_, infos in wander(env, 200):
        assert observations in env.observation_space
        assert infos.get("final_obs", observations) in env.observation_space


def test_no_observation_is_constant(make, wander):
    """Every number of the observation changes from step to step, for every arm."""
    env = make(3, ReachTask(horizon=10), seed=0)
    assert (np.array([observations for observations, *_ in wander(env, 60)]).std(axis=0) > 0.0).all()


def test_what_a_step_returns_is_the_callers(make, stand, wander):
    """No array that was returned changes with the next step, or shares memory with what it returns."""
    env = make(3, seed=0)
    for _ in range(10):
        first = arrays_of(stand(env))
        before = [array.copy() for array in first]
        second = arrays_of(wander(env, 1)[0])
        for array, copy in zip(first, before, strict=True):
            assert_array_equal(array, copy)
        assert not any(np.shares_memory(one, other) for one in first for other in second)


def arrays_of(taken):
    """All arrays that a step returns."""
    *arrays, infos = taken
    return [*arrays, *infos.values()]


def test_what_a_reset_returns_is_the_callers(make, wander):
    """The first observations and infos stay as they are when the episode goes on."""
    env = make(2)
    observations, infos = env.reset(seed=0)
    before = observations.copy(), infos["distance"].copy()
    wander(env, 3)
    assert_array_equal(observations, before[0])
    assert_array_equal(infos["distance"], before[1])


def test_actions_are_left_alone(make):
    """The caller's actions are not changed, also where they are beyond the box."""
    env = make(2, seed=0)
    actions = np.full((2, 6), 5.0, np.float32)
    env.step(actions)
    assert_array_equal(actions, 5.0)


def test_close_can_be_called_twice():
    """A second close does nothing."""
    env = harness.make_env()
    env.reset(seed=0)
    env.close()
    env.close()
    assert env.closed
