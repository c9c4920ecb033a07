"""The policy of soft actor-critic."""

import numpy as np
from hypothesis import example, given, strategies as st
from numpy.random import default_rng
from numpy.testing import assert_allclose

from harness.policy import SquashedGaussian


def test_drawn_actions_have_the_policy_s_distribution(make_network, observations):
    """Before squashing, mean and standard deviation are those of the two heads."""
    policy = make_network(SquashedGaussian, layers=0, scale=0.1)
    seen = observations(1)
    drawn = np.arctanh(policy.act(np.repeat(seen, 20_000, axis=0), default_rng(5)).astype(float))
    mean = np.arctanh(policy.act(seen)[0])
    std = np.exp(seen @ policy.weights["log_std.weight"].T + policy.weights["log_std.bias"])[0]
    assert_allclose(drawn.mean(axis=0), mean, atol=0.05)
    assert_allclose(drawn.std(axis=0), std, rtol=0.05)


@given(st.integers(0, 100), st.floats(-10, 10, width=32), st.floats(-10, 10, width=32), st.booleans())
@example(0, -9.899999618530273, 0.10000000149011612, False)
def test_actions_stay_in_the_box(make_network, observations, seed, low, high, is_drawn):
    """Bounds included, also where tanh is 1 to the last bit and high - low is rounded."""
    low, high = sorted((low, high))
    policy = make_network(SquashedGaussian, seed, low=low, high=high, scale=30.0)
    actions = policy.act(100 * observations(), default_rng(seed) if is_drawn else None)
    assert (actions >= np.float32(low)).all()
    assert (actions <= np.float32(high)).all()


def test_saturated_policy_reaches_both_ends(make_network, observations):
    """The whole box can be used."""
    policy = make_network(SquashedGaussian, low=-0.5, high=2.0, scale=1000.0)
    assert {-0.5, 2.0} <= set(policy.act(observations(100)).ravel().tolist())
