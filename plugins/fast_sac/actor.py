"""The draw of the soft actor's actions, a = tanh(mean + std * noise), and the gradient through it."""

from typing import NamedTuple

import numpy as np

from harness.arrays import Float32

LOWEST_LOG_STD, HIGHEST_LOG_STD = -20.0, 2.0
HALF_LOG_2_PI = 0.5 * float(np.log(2.0 * np.pi))
SMALL = 1e-6
"""Keeps the logarithm of 1 - a^2 finite where tanh is 1."""


class Draw(NamedTuple):
    """Actions, and the quantities from which they were computed."""

    action: Float32
    """In (-1, 1), (..., action_size)."""
    log_prob: Float32
    """Logarithm of their density, (...)."""
    noise: Float32
    """(..., action_size)."""
    std: Float32
    """(..., action_size)."""
    slope: Float32
    """Slope of tanh, 1 - a^2, (..., action_size)."""


def draw(output: Float32, noise: Float32) -> Draw:
    """Draw actions from the output of the actor's network.

    Args:
        output: Means and logarithms of the standard deviations side by side, (..., 2 * action_size).
        noise: Standard normal, (..., action_size).
    """
    size = noise.shape[-1]
    log_std = np.clip(output[..., size:], LOWEST_LOG_STD, HIGHEST_LOG_STD)
    std = np.exp(log_std)
    action: Float32 = np.tanh(output[..., :size] + std * noise)
    slope = 1.0 - action * action
    density = 0.5 * noise * noise + log_std + np.log(slope + SMALL)
    log_prob = -density.sum(axis=-1) - size * HALF_LOG_2_PI
    return Draw(action, log_prob, noise, std, slope)


def put_error(output: Float32, drawn: Draw, by_action: Float32, by_log_prob: float, error: Float32) -> None:
    """Compute the gradient of a loss by the network's output.

    Args:
        output: The output from which the actions were drawn, (rows, 2 * action_size).
        drawn: The draw from this output.
        by_action: Gradient of the loss by the actions, without their effect on log_prob, (rows, action_size).
        by_log_prob: Gradient of the loss by each log_prob.
        error: Gets the result, (rows, 2 * action_size).
    """
    size, slope = by_action.shape[-1], drawn.slope
    # log_prob falls with log(1 - tanh(u)^2), whose derivative by u is -2 tanh(u) (1 - tanh(u)^2) / (1 - tanh(u)^2)
    by_mean = slope * (by_action + 2.0 * by_log_prob * drawn.action / (slope + SMALL))
    error[:, :size] = by_mean
    error[:, size:] = by_mean * drawn.noise * drawn.std - by_log_prob
    log_std = output[:, size:]
    error[:, size:] *= (log_std >= LOWEST_LOG_STD) & (log_std <= HIGHEST_LOG_STD)  # beyond, it was clipped
