"""What DQN learns."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float32
from harness.policy.chooser import ChoosingNetwork

Choice: TypeAlias = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Greedy(ChoosingNetwork):
    """Takes the choice with the highest value, by the head ``value``.

    Attributes:
        epsilon: The share of draws that take any choice with equal chance.
    """

    kind: ClassVar[str] = "greedy"
    heads: ClassVar[tuple[str, ...]] = ("value",)

    epsilon: float = 0.05

    def act(self, observation: Float32, rng: np.random.Generator | None = None) -> Choice:
        """See `harness.policy.policy.Policy.act`; a draw is epsilon-greedy."""
        choice: Choice = self.head(self.hidden(observation), "value").argmax(axis=1)
        if rng is None:
            return choice
        explores = rng.random(len(choice)) < self.epsilon
        return np.where(explores, rng.integers(self.choices, size=len(choice)), choice)

    def card(self) -> dict[str, Any]:
        """See `harness.policy.policy.Policy.card`."""
        return {**super().card(), "epsilon": self.epsilon}

    @classmethod
    def from_card(cls, card: Mapping[str, Any], weights: Mapping[str, Float32]) -> Self:
        """See `harness.policy.policy.Policy.from_card`."""
        epsilon = float(card["epsilon"])
        if not 0.0 <= epsilon <= 1.0:
            raise ValueError(f"epsilon is {epsilon}, not from 0 to 1")
        return replace(super().from_card(card, weights), epsilon=epsilon)
