"""Policies whose actions are a choice out of several: networks that choose, and choices by chance."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float32, Ints
from harness.policy.policy import Network, Policy, require_sound, scatter


@dataclass(frozen=True, eq=False)
class UniformChoice(Policy):
    """Every choice equally often, whatever is observed; of observations of any size.

    Without a generator a choice still is a function of its observation; see `harness.policy.policy.Uniform`.

    Attributes:
        choices: How many there are.
        algorithm: For the reader of the card.
    """

    kind: ClassVar[str] = "uniform-choice"

    choices: int
    algorithm: str = ""
    weights: Mapping[str, Float32] = field(default_factory=dict, init=False)

    def act(self, observation: Float32, rng: np.random.Generator | None = None) -> Ints:
        if rng is not None:
            return rng.integers(self.choices, size=len(observation))
        return (self.choices * scatter(observation, 1)[:, 0]).astype(np.int64)

    def floor(self) -> "UniformChoice":
        return self

    def card(self) -> dict[str, Any]:
        return {"observation": {"size": None}, "action": describe_choices(self.choices)}

    @classmethod
    def from_card(cls, card: Mapping[str, Any], weights: Mapping[str, Float32]) -> Self:
        return cls(choices_of(card), card["algorithm"])


MOST_CHOICES = 100_000
"""Three for each of ten joints together are 59,049."""


def describe_choices(choices: int) -> dict[str, Any]:
    """What a card says of the actions."""
    return {"type": "discrete", "choices": choices}


def choices_of(card: Mapping[str, Any]) -> int:
    """How many choices the actions of a card are.

    Raises:
        KeyError: The card does not say.
        ValueError: It says what cannot be.
    """
    choices = int(card["action"]["choices"])
    if choices < 1:
        raise ValueError(f"{choices} choices leave none")
    if choices > MOST_CHOICES:
        raise ValueError(f"there are {choices:,} choices, {MOST_CHOICES:,} are allowed")
    return choices


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
        return UniformChoice(self.choices)

    def card(self) -> dict[str, Any]:
        return {**super().card(), "action": describe_choices(self.choices)}

    @classmethod
    def from_card(cls, card: Mapping[str, Any], weights: Mapping[str, Float32]) -> Self:
        policy = cls(weights, card["activation"], choices_of(card), card["algorithm"])
        require_sound(policy, policy.choices)
        return policy


Choice: TypeAlias = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Categorical(ChoosingNetwork):
    """Takes the likeliest choice, or draws one. The head ``logits`` has logarithms of unnormalised probabilities."""

    kind: ClassVar[str] = "categorical"
    heads: ClassVar[tuple[str, ...]] = ("logits",)

    def act(self, observation: Float32, rng: np.random.Generator | None = None) -> Choice:
        logits = self.head(self.hidden(observation), "logits")
        if rng is not None:
            # The largest of logits that each got Gumbel noise is a draw from their distribution.
            logits += rng.gumbel(size=logits.shape)
        choice: Choice = logits.argmax(axis=1)
        return choice


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
        return {**super().card(), "epsilon": self.epsilon}

    @classmethod
    def from_card(cls, card: Mapping[str, Any], weights: Mapping[str, Float32]) -> Self:
        epsilon = float(card["epsilon"])
        if not 0.0 <= epsilon <= 1.0:
            raise ValueError(f"epsilon is {epsilon}, not from 0 to 1")
        return replace(super().from_card(card, weights), epsilon=epsilon)
