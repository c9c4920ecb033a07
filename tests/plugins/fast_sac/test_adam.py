"""Adam: the steps of torch's."""

import numpy as np
import torch
from numpy.random import default_rng
from numpy.testing import assert_allclose

from harness_plugins.fast_sac.training import Adam


def test_steps_are_those_of_torch():
    """Over 200 steps with gradients of all sizes, and with none, to float32's rounding."""
    rng = default_rng(0)
    parameters, gradient = rng.standard_normal(50).astype(np.float32), np.empty(50, np.float32)
    theirs = torch.tensor(parameters, requires_grad=True)
    ours, other = Adam(parameters, gradient, 3e-3), torch.optim.Adam([theirs], 3e-3)
    scale = 10.0 ** np.linspace(-9, 3, 50)
    scale[0] = 0.0
    for _ in range(200):
        gradient[...] = scale * rng.standard_normal(50)
        theirs.grad = torch.tensor(gradient)
        ours.step()
        other.step()
    assert_allclose(parameters, theirs.detach().numpy(), rtol=1e-4, atol=1e-5)


def test_without_a_gradient_nothing_moves():
    """Not even by a division by zero."""
    parameters, gradient = np.ones(3, np.float32), np.zeros(3, np.float32)
    adam = Adam(parameters, gradient, 0.1)
    for _ in range(3):
        adam.step()
    assert parameters.tolist() == [1.0, 1.0, 1.0]
