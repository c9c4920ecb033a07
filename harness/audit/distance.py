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
    first, second = (canonical_values(reward, rollouts, gamma, coverage) for reward in (one, other))
    value = distance_between(centred_unit(*first), centred_unit(*second))
    return Distance(value, sum(int(rollout.running.sum()) for rollout in rollouts))


def distance_between(one: Float | None, other: Float | None) -> float | None:
    """Half the length between two vectors of length 1, in [0, 1]; None stands for a vector of length 0.

    Of two that `centred_unit` made it is sqrt((1 - rho) / 2), with rho their correlation. It is 0 where both are None,
    and None, not defined, where one of them is.
    """
    if one is None and other is None:
        return 0.0
    if one is None or other is None:
        return None
    return min(1.0, float(np.linalg.norm(one - other)) / 2.0)


def centred_unit(values: Float, largest: float) -> Float | None:
    """The values without their mean and of length 1; None where they are constant.

    Args:
        values: Of each transition, (transitions,), at least one.
        largest: The largest that the reward paid; what is small beside it is nothing.
    """
    return unit(values - values.mean(), largest)


def unit(values: Float, largest: float) -> Float | None:
    """The same without taking the mean away; None where they are 0."""
    length = float(np.linalg.norm(values))
    if not length > NOTHING * largest * np.sqrt(len(values)):
        return None
    scaled: Float = values / length
    return scaled
