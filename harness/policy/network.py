"""A multi-layer perceptron in numpy, NOTE definition 4: what all policies that were learned have in common."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, TypeAlias

import numpy as np

from harness.arrays import Float32
from harness.policy.policy import Policy

Layer: TypeAlias = tuple[Float32, Float32]
"""Weight (in, out) and bias (out,)."""

MEAN, STD = "observation.mean", "observation.std"
ZERO = np.zeros((), np.float32)


def _relu(values: Float32) -> None:
    np.maximum(values, ZERO, out=values)


def _tanh(values: Float32) -> None:
    np.tanh(values, out=values)


ACTIVATIONS: dict[str, Callable[[Float32], None]] = {"relu": _relu, "tanh": _tanh}
"""What may stand between the layers; each works in place."""


@dataclass(frozen=True, eq=False)
class Network(Policy):
    """Hidden layers, and linear heads that each kind names.

    Attributes:
        weights: ``hidden.i.weight`` (out, in) and ``hidden.i.bias`` (out,) for each hidden layer, the same for each
            head; ``observation.mean`` and ``observation.std`` (observation_size,) where observations are to be
            shifted and scaled first; float32.
        activation: After each hidden layer, ``relu`` or ``tanh``.
    """

    heads: ClassVar[tuple[str, ...]]
    """Names of the linear heads; the first one has an output for each action or choice."""

    weights: Mapping[str, Float32]
    activation: str

    @property
    def observation_size(self) -> int:
        """Numbers in an observation."""
        first = "hidden.0.weight" if self.depth else f"{self.heads[0]}.weight"
        return int(self.weights[first].shape[1])

    @cached_property
    def depth(self) -> int:
        """How many hidden layers there are."""
        return sum(name.startswith("hidden.") and name.endswith(".weight") for name in self.weights)

    @property
    def is_normalised(self) -> bool:
        """Whether observations are shifted and scaled before the first layer."""
        return MEAN in self.weights

    def card(self) -> dict[str, Any]:
        """See `Policy.card`."""
        return {
            "observation": {"size": self.observation_size},
            "normalisation": {"mean": MEAN, "std": STD} if self.is_normalised else None,
            "activation": self.activation,
        }

    def hidden(self, observation: Float32) -> Float32:
        """The last hidden layer, (num_envs, width); without hidden layers the observation, scaled."""
        values = np.asarray(observation, np.float32)
        if self._scaling is not None:
            mean, std = self._scaling
            values = values - mean
            values /= std
        activate = self._activate
        for weight, bias in self._layers:
            values = values @ weight
            values += bias
            activate(values)
        return values

    def head(self, hidden: Float32, name: str) -> Float32:
        """A linear head on the last hidden layer, (num_envs, out), a new array."""
        weight, bias = self._heads[name]
        values: Float32 = hidden @ weight
        values += bias
        return values

    # Looked up once: asking for an array by its name costs as much as a small product.

    @cached_property
    def _layers(self) -> tuple[Layer, ...]:
        return tuple(self._layer(f"hidden.{index}") for index in range(self.depth))

    @cached_property
    def _heads(self) -> dict[str, Layer]:
        return {name: self._layer(name) for name in self.heads}

    @cached_property
    def _activate(self) -> Callable[[Float32], None]:
        return ACTIVATIONS[self.activation]

    @cached_property
    def _scaling(self) -> Layer | None:
        return (self.weights[MEAN], self.weights[STD]) if self.is_normalised else None

    def _layer(self, name: str) -> Layer:
        # A product with a row is quickest where the columns lie in one piece.
        return np.ascontiguousarray(self.weights[f"{name}.weight"].T), self.weights[f"{name}.bias"]
