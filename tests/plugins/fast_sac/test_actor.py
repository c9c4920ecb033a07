"""The soft actor's draw: that of stable-baselines3, and the derivatives that torch finds."""

import numpy as np
import pytest
import torch
from numpy.random import default_rng
from numpy.testing import assert_allclose
from stable_baselines3.common.distributions import SquashedDiagGaussianDistribution

from harness_plugins.fast_sac.training import draw, put_error

ROWS, SIZE = 40, 6


def some_output(rng):
    """Means, and logarithms of deviations, some of them beyond where they are cut off.

    Small enough for 1 - tanh^2 not to be lost in the rounding of float32.
    """
    output = 0.4 * rng.standard_normal((ROWS, 2 * SIZE), dtype=np.float32)
    output[0, SIZE] = 2.1
    output[1, SIZE + 1] = -25.0
    return output


def some_noise(rng):
    """Normal numbers, a small one for the largest deviation."""
    noise = rng.standard_normal((ROWS, SIZE), dtype=np.float32)
    noise[0, 0] = 0.1
    return noise


def by_torch(output, noise):
    """Actions and their log_prob, by the library's distribution."""
    distribution = SquashedDiagGaussianDistribution(SIZE)
    log_std = torch.clamp(output[:, SIZE:], -20.0, 2.0)
    distribution.proba_distribution(output[:, :SIZE], log_std)
    gaussian = output[:, :SIZE] + noise * log_std.exp()
    action = torch.tanh(gaussian)
    return action, distribution.log_prob(action, gaussian)


def test_draws_and_their_log_prob_are_those_of_the_library():
    """To the rounding of float32; the library is asked in float64, as it divides by tiny deviations."""
    rng = default_rng(0)
    output, noise = some_output(rng), some_noise(rng)
    ours = draw(output, noise)
    action, log_prob = by_torch(torch.tensor(output).double(), torch.tensor(noise).double())
    assert_allclose(ours.action, action.numpy(), rtol=1e-5, atol=1e-6)
    assert_allclose(ours.log_prob, log_prob.numpy(), rtol=1e-3, atol=1e-3)


def test_error_is_the_derivative():
    """Of a loss of actions and log_prob, by automatic differentiation of the library's distribution."""
    rng = default_rng(1)
    output, noise = some_output(rng), some_noise(rng)
    by_action = rng.standard_normal((ROWS, SIZE), dtype=np.float32)
    leaf = torch.tensor(output, dtype=torch.float64, requires_grad=True)
    action, log_prob = by_torch(leaf, torch.tensor(noise, dtype=torch.float64))
    (0.3 * log_prob.sum() + (torch.tensor(by_action) * action).sum()).backward()
    error = np.empty_like(output)
    put_error(output, draw(output, noise), by_action, 0.3, error)
    assert leaf.grad is not None
    assert_allclose(error, leaf.grad.numpy(), rtol=2e-3, atol=2e-3)


@pytest.mark.parametrize("log_std", [-25.0, 3.0])
def test_no_way_back_where_the_deviation_is_cut_off(log_std):
    """A deviation that cannot change is not asked to."""
    output = np.array([[0.1, log_std]], np.float32)
    error = np.empty_like(output)
    put_error(output, draw(output, np.ones((1, 1), np.float32)), np.ones((1, 1), np.float32), 0.5, error)
    assert error[0, 1] == 0.0


def test_actions_at_the_edge_have_a_finite_log_prob():
    """Where tanh is 1 to float32's rounding."""
    drawn = draw(np.array([[50.0, -5.0]], np.float32), np.zeros((1, 1), np.float32))
    assert drawn.action[0, 0] == 1.0
    assert np.isfinite(drawn.log_prob).all()
