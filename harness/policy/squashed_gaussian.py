"""What soft actor-critic learns."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from harness.arrays import Float32
from harness.policy.continuous import ContinuousNetwork


@dataclass(frozen=True, eq=False)
class SquashedGaussian(ContinuousNetwork):
    """A Gaussian multi-layer perceptron, NOTE eq. 37, squashed into the action box.

    The mean and the logarithm of the standard deviation are linear in the last hidden layer, the heads ``mean`` and
    ``log_std``; a draw is squashed by tanh and scaled from [-1, 1] to [action_low, action_high].
    """

    kind: ClassVar[str] = "squashed-gaussian"
    heads: ClassVar[tuple[str, ...]] = ("mean", "log_std")
    squashes: ClassVar[bool] = True

    def act(self, observation: Float32, rng: np.random.Generator | None = None) -> Float32:
        """See `harness.policy.policy.Policy.act`."""
        hidden = self.hidden(observation)
        action = self.head(hidden, "mean")
        if rng is not None:
            std = np.exp(np.clip(self.head(hidden, "log_std"), -20.0, 2.0))
            action += std * rng.standard_normal(action.shape, dtype=np.float32)
        return self._squash(action)
