"""The floor of discrete actions."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float32
from harness.policy.choices import choices_of, describe_choices
from harness.policy.policy import Policy
from harness.policy.scatter import scatter


@dataclass(frozen=True, eq=False)
class UniformChoice(Policy):
    """Every choice equally often, whatever is observed; of observations of any size.

    Without a generator a choice still is a function of its observation; see `harness.policy.uniform.Uniform`.

    Attributes:
        choices: How many there are.
        algorithm: For the reader of the card.
    """

    kind: ClassVar[str] = "uniform-choice"

    choices: int
    algorithm: str = ""
    weights: Mapping[str, Float32] = field(default_factory=dict, init=False)

    def act(self, observation: Float32, rng: np.random.Generator | None = None) -> NDArray[np.int64]:
        """See `harness.policy.policy.Policy.act`."""
        if rng is not None:
            return rng.integers(self.choices, size=len(observation))
        return (self.choices * scatter(observation, 1)[:, 0]).astype(np.int64)

    def floor(self) -> "UniformChoice":
        """Itself."""
        return self

    def card(self) -> dict[str, Any]:
        """See `harness.policy.policy.Policy.card`."""
        return {"observation": {"size": None}, "action": describe_choices(self.choices)}

    @classmethod
    def from_card(cls, card: Mapping[str, Any], weights: Mapping[str, Float32]) -> Self:
        """See `harness.policy.policy.Policy.from_card`."""
        return cls(choices_of(card), card["algorithm"])
