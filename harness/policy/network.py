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


def require_sound(network: Network, outputs: int) -> None:
    """Look at what `act` would meet much later, or never complain of.

    Args:
        network: As it was read.
        outputs: Of each head.

    Raises:
        KeyError: A part is missing.
        ValueError: A part cannot be, or does not fit the others.
    """
    if network.activation not in ACTIVATIONS:
        raise ValueError(f"no activation {network.activation!r}; there is: {', '.join(ACTIVATIONS)}")
    for name, array in network.weights.items():
        if not np.isfinite(array).all():
            raise ValueError(f"{name} has numbers that are not finite")
    layers = {int(name.split(".")[1]) for name in network.weights if name.startswith("hidden.")}
    width = None
    for index in range(1 + max(layers, default=-1)):
        width = _outputs_of(network, f"hidden.{index}", width)
    if network.depth > len(layers):
        raise ValueError("a hidden layer is there twice")
    for head in network.heads:
        if _outputs_of(network, head, width) != outputs:
            raise ValueError(f"{head} does not have {outputs} outputs")
    if MEAN in network.weights or STD in network.weights:
        _require_scaling(network)


def _outputs_of(network: Network, layer: str, inputs: int | None) -> int:
    """The width of a layer; `inputs` is that of the layer before, None where there is none."""
    weight, bias = network.weights[f"{layer}.weight"], network.weights[f"{layer}.bias"]
    if weight.ndim != 2 or bias.shape != weight.shape[:1] or inputs not in {None, weight.shape[1]}:
        raise ValueError(f"{layer} is {weight.shape} and {bias.shape}, on {inputs or weight.shape[-1:]} inputs")
    return int(weight.shape[0])


def _require_scaling(network: Network) -> None:
    for name in (MEAN, STD):
        if network.weights[name].shape != (network.observation_size,):
            raise ValueError(f"{name} is {network.weights[name].shape}, on {network.observation_size} numbers")
    if not (network.weights[STD] > 0.0).all():
        raise ValueError(f"{STD} is not above 0 everywhere")
