"""Numbers that look drawn, and are the same for the same observation."""

import hashlib

import numpy as np

from harness.arrays import Float, Float32


def scatter(observation: Float32, size: int) -> Float:
    """Uniform numbers that depend on each observation alone: not on the batch, nor on what was asked before.

    Args:
        observation: (num_envs, observation_size).
        size: How many for each.

    Returns:
        (num_envs, size), in [0, 1).
    """
    rows = np.ascontiguousarray(observation, np.float32) + np.float32(0.0)  # -0 is 0
    return np.array([_generator(row.tobytes()).random(size) for row in rows]).reshape(len(rows), size)


def _generator(seen: bytes) -> np.random.Generator:
    return np.random.default_rng(int.from_bytes(hashlib.blake2b(seen, digest_size=16).digest()))
