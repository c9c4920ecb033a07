"""The policy of policy gradients where actions are choices."""

import numpy as np
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.policy import Categorical


def test_draws_have_the_probabilities_of_the_logits(make_network, observations):
    """NOTE eq. 35: each choice as often as its share of the exponentials."""
    policy = make_network(Categorical, layers=0, scale=0.5)
    drawn = policy.act(np.repeat(observations(1), 20_000, axis=0), default_rng(5))
    logits = (observations(1) @ policy.weights["logits.weight"].T + policy.weights["logits.bias"])[0]
    expected = np.exp(logits) / np.exp(logits).sum()
    assert expected.min() > 0.05
    assert_allclose(np.bincount(drawn, minlength=3) / len(drawn), expected, atol=0.015)


def test_adding_to_all_logits_changes_nothing(make_network, observations):
    """Only differences count, for the likeliest choice and for a draw."""
    policy = make_network(Categorical)
    more = {**policy.weights, "logits.bias": policy.weights["logits.bias"] + np.float32(3.0)}
    other = Categorical(more, policy.activation, 3)
    for seed in (None, 7):
        first, second = (
            each.act(observations(50), None if seed is None else default_rng(seed)) for each in (policy, other)
        )
        assert_array_equal(first, second)
