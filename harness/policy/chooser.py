"""A network that chooses."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

from harness.arrays import Float32
from harness.policy.choices import choices_of, describe_choices
from harness.policy.network import Network
from harness.policy.soundness import require_sound
from harness.policy.uniform_choice import UniformChoice


@dataclass(frozen=True, eq=False)
class ChoosingNetwork(Network):
    """What the kinds with discrete actions share.

    Attributes:
        choices: How many there are; the first head has an output for each.
        algorithm: What trained it, for the reader of the card.
    """

    choices: int
    algorithm: str = ""

    def floor(self) -> UniformChoice:
        """See `harness.policy.policy.Policy.floor`."""
        return UniformChoice(self.choices)

    def card(self) -> dict[str, Any]:
        """See `harness.policy.policy.Policy.card`."""
        return {**super().card(), "action": describe_choices(self.choices)}

    @classmethod
    def from_card(cls, card: Mapping[str, Any], weights: Mapping[str, Float32]) -> Self:
        """See `harness.policy.policy.Policy.from_card`."""
        policy = cls(weights, card["activation"], choices_of(card), card["algorithm"])
        require_sound(policy, policy.choices)
        return policy
