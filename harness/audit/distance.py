"""How far apart two rewards are, apart from scale, offset and potential shaping."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from harness.audit.canonical import Coverage, canonical_values
from harness.audit.rollout import Rollout
from harness.audit.unit_vectors import centred_unit, distance_between
from harness.reward import Reward


@dataclass(frozen=True)
class Distance:
    """Pearson distance of two rewards in canonical form.

    Attributes:
        value: sqrt((1 - rho) / 2), in [0, 1]: 0 the same but for scale, offset and potential shaping, 0.71
            unrelated, 1 opposite; None where exactly one of the two is nothing but an offset and potential shaping.
        transitions: How many recorded steps it rests on.
        reason: Why there is no value, where it is another reason.
    """

    value: float | None
    transitions: int
    reason: str = ""

    def to_json(self) -> dict[str, Any]:
        """Plain data; the reason is left out where there is none."""
        return {name: value for name, value in asdict(self).items() if name != "reason" or value}


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
