"""What PPO and its relatives learn."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from harness.arrays import Float32
from harness.policy.continuous import ContinuousNetwork

LOG_STD = "log_std"


@dataclass(frozen=True, eq=False)
class Gaussian(ContinuousNetwork):
    """A Gaussian multi-layer perceptron, NOTE eq. 37, whose deviation is the same in every state.

    The mean is linear in the last hidden layer, the head ``mean``; the logarithm of the standard deviation is the
    array ``log_std`` (action_size,). Actions outside the box are clipped to it.
    """

    kind: ClassVar[str] = "gaussian"
    heads: ClassVar[tuple[str, ...]] = ("mean",)
    squashes: ClassVar[bool] = False

    def act(self, observation: Float32, rng: np.random.Generator | None = None) -> Float32:
        """See `harness.policy.policy.Policy.act`."""
        action = self.head(self.hidden(observation), "mean")
        if rng is not None:
            action += np.exp(self.weights[LOG_STD]) * rng.standard_normal(action.shape, dtype=np.float32)
        return self._clip(action)

    @classmethod
    def from_card(cls, card: Mapping[str, Any], weights: Mapping[str, Float32]) -> Self:
        """See `harness.policy.policy.Policy.from_card`."""
        policy = super().from_card(card, weights)
        if weights[LOG_STD].shape != (len(policy.action_low),):
            raise ValueError(f"{LOG_STD} is {weights[LOG_STD].shape}, on {len(policy.action_low)} actions")
        return policy
