"""The policy of DQN."""

import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_allclose

from harness.policy import Greedy


@pytest.mark.parametrize("epsilon", [0.0, 0.3, 1.0])
def test_a_draw_explores_that_often(make_network, observations, epsilon):
    """A share epsilon is uniform among all choices, the best one included."""
    policy = make_network(Greedy, epsilon=epsilon)
    drawn = policy.act(np.repeat(observations(1), 20_000, axis=0), default_rng(5))
    expected = np.full(3, epsilon / 3)
    expected[policy.act(observations(1))[0]] += 1.0 - epsilon
    assert_allclose(np.bincount(drawn, minlength=3) / len(drawn), expected, atol=0.015)


def test_of_equal_values_the_first_is_chosen(observations):
    """A tie is no matter of chance."""
    weights = {"value.weight": np.zeros((3, 5), np.float32), "value.bias": np.array([0, 1, 1], np.float32)}
    assert Greedy(weights, "relu", 3).act(observations()).tolist() == [1, 1, 1, 1]
