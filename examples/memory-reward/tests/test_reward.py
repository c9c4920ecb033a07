"""The reward keeps its contract, and pays what its equation says."""

from itertools import pairwise

import numpy as np
from memory_reward.reward import Steady

from harness.reward import Sample
from harness_plugins.kit import check_contract

BEGIN = np.array([0.5])


def step(before: float, after: float) -> Sample:
    """From one distance to another, [m]."""
    last, now = np.array([before]), np.array([after])
    return Sample(BEGIN, last, last, now, now - last, np.array([1]))


def test_contract() -> None:
    """It is finite, pure, the same in any batch, and works with arrays of any library."""
    check_contract("reward", Steady())


def test_known_steps() -> None:
    """The first gain is paid less half of itself, the second one less half of what differs from the mean of 0.02 m."""
    reward = Steady(price=0.5, share=0.2)
    carry, first = reward(reward.initial_carry(BEGIN), step(0.5, 0.4))
    np.testing.assert_allclose((carry, first), [[0.02], [0.05]])
    carry, second = reward(carry, step(0.4, 0.3))
    np.testing.assert_allclose((carry, second), [[0.036], [0.1 - 0.5 * 0.08]])


def test_an_even_way_pays_more_than_one_in_jerks() -> None:
    """From 0.5 m to 0.1 m in four steps: 0.1 m each, or 0.2 m and then nothing by turns."""
    assert total([0.5, 0.4, 0.3, 0.2, 0.1]) > total([0.5, 0.3, 0.3, 0.1, 0.1])


def total(distances: list[float]) -> float:
    """What an episode with these distances pays."""
    reward = Steady()
    carry, paid = reward.initial_carry(BEGIN), 0.0
    for before, after in pairwise(distances):
        carry, value = reward(carry, step(before, after))
        paid += value.item()
    return paid
