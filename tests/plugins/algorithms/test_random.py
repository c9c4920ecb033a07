"""Random: the floor, with a trace like any training's."""

import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_array_equal
from scipy import stats

from harness.algorithm import learns
from harness.policy import Uniform, UniformChoice
from harness_plugins.algorithms.random import Random
from harness_plugins.kit.trainings import train


def test_it_says_that_it_does_not_learn():
    """So that nobody asks it to."""
    assert not learns(Random())


def test_actions_of_its_training_are_uniform():
    """In the whole box, in the middle of an episode."""
    done = train(Random(num_envs=50), 4650, space="continuous")
    assert stats.kstest(done.env.episodes.action.ravel(), "uniform", (-1.0, 2.0)).pvalue > 1e-3
    assert isinstance(done.policy, Uniform)
    assert done.policy.algorithm == "random"


def test_it_takes_discrete_actions():
    """Every choice equally often."""
    policy = train(Random(), 10, space="discrete").policy
    assert isinstance(policy, UniformChoice)
    drawn = policy.act(np.zeros((13_000, 28), np.float32), default_rng(0))
    assert stats.chisquare(np.bincount(drawn, minlength=13)).pvalue > 1e-3


@pytest.mark.parametrize("num_envs", [1, 7])
def test_seed_decides_what_it_does(num_envs):
    """One seed, one trace; another seed, another."""
    ends = [train(Random(num_envs=num_envs), 91, seed=seed).env.episodes.matrix for seed in (0, 0, 1)]
    assert_array_equal(ends[0], ends[1])
    assert not np.array_equal(ends[0], ends[2])
