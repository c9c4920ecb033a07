"""A network whose actions fill a box."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np

from harness.arrays import Float32
from harness.policy.box import box_of, describe_box
from harness.policy.network import Network
from harness.policy.soundness import require_sound
from harness.policy.uniform import Uniform

ONE = np.ones((), np.float32)


@dataclass(frozen=True, eq=False)
class ContinuousNetwork(Network):
    """What the kinds with continuous actions share.

    Attributes:
        action_low: Lower end of each action, (action_size,).
        action_high: Upper end of each action, (action_size,).
        algorithm: What trained it, for the reader of the card.
    """

    squashes: ClassVar[bool]
    """Whether tanh brings the first head into the box; otherwise it is clipped to it."""

    action_low: tuple[float, ...]
    action_high: tuple[float, ...]
    algorithm: str = ""

    def floor(self) -> Uniform:
        """See `harness.policy.policy.Policy.floor`."""
        return Uniform(self.action_low, self.action_high)

    def card(self) -> dict[str, Any]:
        """See `harness.policy.policy.Policy.card`."""
        return {**super().card(), "action": describe_box(self.action_low, self.action_high)}

    @classmethod
    def from_card(cls, card: Mapping[str, Any], weights: Mapping[str, Float32]) -> Self:
        """See `harness.policy.policy.Policy.from_card`."""
        low, high = box_of(card)
        policy = cls(weights, card["activation"], low, high, card["algorithm"])
        require_sound(policy, len(low))
        return policy

    @cached_property
    def bounds(self) -> tuple[Float32, Float32, Float32]:
        """Lower ends, upper ends and half of what lies between, (action_size,) each."""
        low, high = np.array([self.action_low, self.action_high], np.float32)
        return low, high, np.float32(0.5) * (high - low)

    def _clip(self, action: Float32) -> Float32:
        """The nearest actions in the box; in place."""
        low, high, _ = self.bounds
        np.maximum(action, low, out=action)
        np.minimum(action, high, out=action)
        return action

    def _squash(self, action: Float32) -> Float32:
        """From all numbers into the box, by tanh; in place."""
        low, _, half = self.bounds
        np.tanh(action, out=action)
        action += ONE
        action *= half
        action += low
        return self._clip(action)  # the half is rounded
