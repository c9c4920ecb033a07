"""What policy gradients learn where actions are choices."""

from dataclasses import dataclass
from typing import ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float32
from harness.policy.chooser import ChoosingNetwork

Choice: TypeAlias = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Categorical(ChoosingNetwork):
    """Takes the likeliest choice, or draws one. The head ``logits`` has logarithms of unnormalised probabilities."""

    kind: ClassVar[str] = "categorical"
    heads: ClassVar[tuple[str, ...]] = ("logits",)

    def act(self, observation: Float32, rng: np.random.Generator | None = None) -> Choice:
        """See `harness.policy.policy.Policy.act`."""
        logits = self.head(self.hidden(observation), "logits")
        if rng is not None:
            # The largest of logits that each got Gumbel noise is a draw from their distribution.
            logits += rng.gumbel(size=logits.shape)
        choice: Choice = logits.argmax(axis=1)
        return choice
