"""The floor of continuous actions."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Self

import numpy as np

from harness.arrays import Float32
from harness.policy.box import box_of, describe_box
from harness.policy.policy import Policy
from harness.policy.scatter import scatter


@dataclass(frozen=True, eq=False)
class Uniform(Policy):
    """Actions that are uniform in the box, whatever is observed; of observations of any size.

    Without a generator an action still is a function of its observation, NOTE eq. 36: a scattered one, see
    `harness.policy.scatter`.

    Attributes:
        action_low: Lower end of each action, (action_size,).
        action_high: Upper end of each action, (action_size,).
        algorithm: For the reader of the card.
    """

    kind: ClassVar[str] = "uniform"

    action_low: tuple[float, ...]
    action_high: tuple[float, ...]
    algorithm: str = ""
    weights: Mapping[str, Float32] = field(default_factory=dict, init=False)

    def act(self, observation: Float32, rng: np.random.Generator | None = None) -> Float32:
        """See `harness.policy.policy.Policy.act`."""
        shape = len(observation), len(self.action_low)
        low, high = np.array(self.action_low), np.array(self.action_high)
        share = rng.random(shape) if rng is not None else scatter(observation, shape[1])
        action: Float32 = np.minimum(low + (high - low) * share, high).astype(np.float32)  # high - low is rounded
        return action

    def floor(self) -> "Uniform":
        """Itself."""
        return self

    def card(self) -> dict[str, Any]:
        """See `harness.policy.policy.Policy.card`."""
        return {"observation": {"size": None}, "action": describe_box(self.action_low, self.action_high)}

    @classmethod
    def from_card(cls, card: Mapping[str, Any], weights: Mapping[str, Float32]) -> Self:
        """See `harness.policy.policy.Policy.from_card`."""
        return cls(*box_of(card), card["algorithm"])
