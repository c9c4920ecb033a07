"""How far apart two rewards are, apart from scale, offset and potential shaping."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from harness.arrays import Float
from harness.audit.canonical import Coverage, canonical_values
from harness.audit.rollout import Rollout
from harness.reward import Reward

NOTHING = 1e-9
"""A canonical reward whose spread is a smaller share than this of the largest value paid is constant."""


@dataclass(frozen=True)
class Distance:
    """Pearson distance of two rewards in canonical form.

    Attributes:
        value: sqrt((1 - rho) / 2), in [0, 1]: 0 the same but for scale, offset and potential shaping, 0.71
            unrelated, 1 opposite; None where exactly one of the two is nothing but an offset and potential shaping.
        transitions: How many recorded steps it rests on.
    """

    value: float | None
    transitions: int


def reward_distance(
    one: Reward, other: Reward, rollouts: Sequence[Rollout], gamma: float, coverage: Coverage
) -> Distance:
    """How differently two rewards rank what can be done in the recorded rollouts.

    The transitions that are compared are all recorded steps of all scripts, each weighing the same.

    Args:
        one: A reward.
        other: Another one; the order does not count.
        rollouts: One of each script.
        gamma: Discount per step.
        coverage: `harness.audit.canonical.anywhere` for EPIC, `harness.audit.canonical.nearby` for DARD.
    """
    first, second = (_unit(*canonical_values(reward, rollouts, gamma, coverage)) for reward in (one, other))
    if first is None and second is None:
        value: float | None = 0.0
    elif first is None or second is None:
        value = None
    else:
        value = min(1.0, float(np.linalg.norm(first - second)) / 2.0)  # of unit vectors: sqrt((1 - rho) / 2)
    return Distance(value, sum(int(rollout.running.sum()) for rollout in rollouts))


def _unit(values: Float, largest: float) -> Float | None:
    """The values without their mean and of length 1; None where they are constant."""
    centred = values - values.mean()
    length = float(np.linalg.norm(centred))
    if not length > NOTHING * largest * np.sqrt(len(values)):
        return None
    unit: Float = centred / length
    return unit
