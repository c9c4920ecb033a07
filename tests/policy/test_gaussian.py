"""The policy of PPO and its relatives."""

from collections.abc import Callable

import numpy as np
from hypothesis import given, strategies as st
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.policy import Gaussian

Make = Callable[..., Gaussian]
Observations = Callable[..., np.ndarray]


def test_drawn_actions_have_the_policy_s_distribution(make_network, observations):
    """NOTE eq. 37: the mean is the head's, the deviation that of the array."""
    policy = make_network(Gaussian, low=-1e3, high=1e3)
    drawn = policy.act(np.repeat(observations(1), 20_000, axis=0), default_rng(5))
    std = np.exp(policy.weights["log_std"])
    assert_allclose(drawn.mean(axis=0), policy.act(observations(1))[0], atol=0.05 * std.max())
    assert_allclose(drawn.std(axis=0), std, rtol=0.05)


def test_deviation_is_the_same_in_every_state(make_network, observations):
    """The same generator moves every action by the same amount."""
    policy = make_network(Gaussian, low=-1e3, high=1e3)
    moved = [policy.act(row[None], default_rng(2)) - policy.act(row[None]) for row in observations()]
    assert_allclose(moved, np.repeat(moved[:1], len(moved), axis=0), atol=1e-5)


@given(st.integers(0, 100), st.floats(-1, 0, width=32), st.floats(0, 1, width=32), st.booleans())
def test_actions_are_clipped_to_the_box(make_network, observations, seed, low, high, is_drawn):
    """An action outside goes to the nearest in the box, and one inside stays."""
    narrow, wide = (make_network(Gaussian, seed, low=a, high=b) for a, b in ((low, high), (-1e3, 1e3)))
    clipped, free = (policy.act(observations(), default_rng(seed) if is_drawn else None) for policy in (narrow, wide))
    assert_array_equal(clipped, np.clip(free, np.float32(low), np.float32(high)))
