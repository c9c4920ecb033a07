"""What TD3 and DDPG learn."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from harness.arrays import Float32
from harness.policy.box import LARGEST
from harness.policy.continuous import ContinuousNetwork


@dataclass(frozen=True, eq=False)
class Deterministic(ContinuousNetwork):
    """One action for each state, NOTE eq. 36, the head ``mean`` squashed by tanh into the action box.

    Attributes:
        noise: Standard deviation of the noise that a draw adds, as a share of half the width of the box.
    """

    kind: ClassVar[str] = "deterministic"
    heads: ClassVar[tuple[str, ...]] = ("mean",)
    squashes: ClassVar[bool] = True

    noise: float = 0.1

    def act(self, observation: Float32, rng: np.random.Generator | None = None) -> Float32:
        """See `harness.policy.policy.Policy.act`; a draw adds normal noise and clips."""
        action = self._squash(self.head(self.hidden(observation), "mean"))
        if rng is None:
            return action
        _, _, half = self.bounds
        action += np.float32(self.noise) * half * rng.standard_normal(action.shape, dtype=np.float32)
        return self._clip(action)

    def card(self) -> dict[str, Any]:
        """See `harness.policy.policy.Policy.card`."""
        return {**super().card(), "noise": self.noise}

    @classmethod
    def from_card(cls, card: Mapping[str, Any], weights: Mapping[str, Float32]) -> Self:
        """See `harness.policy.policy.Policy.from_card`."""
        noise = float(card["noise"])
        if not 0.0 <= noise <= LARGEST:
            raise ValueError(f"noise is {noise}, not a number from 0 to {LARGEST:g}")
        return replace(super().from_card(card, weights), noise=noise)
