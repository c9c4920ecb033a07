"""The policy of TD3 and DDPG."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.policy import Deterministic


@pytest.mark.parametrize("noise", [0.02, 0.1])
def test_a_draw_adds_normal_noise(make_network, observations, noise):
    """Around the one action, with a deviation of that share of half the box."""
    policy = make_network(Deterministic, scale=0.1, low=-1.0, high=3.0, noise=noise)
    drawn = policy.act(np.repeat(observations(1), 20_000, axis=0), default_rng(5))
    assert_allclose(drawn.mean(axis=0), policy.act(observations(1))[0], atol=0.01)
    assert_allclose(drawn.std(axis=0), noise * 2.0, rtol=0.05)


def test_without_noise_a_draw_is_the_one_action(make_network, observations):
    """A noise of 0 adds none."""
    policy = make_network(Deterministic, noise=0.0)
    assert_array_equal(policy.act(observations(), default_rng(0)), policy.act(observations()))


@given(st.integers(0, 100), st.floats(-10, 10, width=32), st.floats(-10, 10, width=32), st.booleans())
def test_actions_stay_in_the_box(make_network, observations, seed, low, high, is_drawn):
    """Bounds included, noise or not."""
    low, high = sorted((low, high))
    policy = make_network(Deterministic, seed, low=low, high=high, scale=30.0, noise=1.0)
    actions = policy.act(observations(), default_rng(seed) if is_drawn else None)
    assert (actions >= np.float32(low)).all()
    assert (actions <= np.float32(high)).all()
