"""A policy that acts with numpy alone, saved without pickle."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import safetensors
import safetensors.numpy
from numpy.typing import NDArray

from harness.errors import SchemaError

FORMAT = 1
WEIGHTS, CARD = "weights.safetensors", "card.json"
Float32 = NDArray[np.float32]


def _relu(values: Float32) -> Float32:
    positive: Float32 = np.maximum(values, np.float32(0.0))
    return positive


ACTIVATIONS: dict[str, Callable[[Float32], Float32]] = {"relu": _relu, "tanh": np.tanh}


@dataclass(frozen=True, eq=False)
class Policy:
    """A Gaussian multi-layer perceptron squashed into the action box, NOTE eq. 37.

    The mean and the logarithm of the standard deviation are linear in the last hidden layer; a draw is squashed by
    tanh and scaled from [-1, 1] to [action_low, action_high].

    Attributes:
        weights: ``hidden.i.weight`` (out, in) and ``hidden.i.bias`` (out,) for each hidden layer, ``mean.*`` and
            ``log_std.*`` for the two heads; float32.
        activation: Between the layers, ``relu`` or ``tanh``.
        action_low: Lower end of each action, (action_size,).
        action_high: Upper end of each action, (action_size,).
        algorithm: What trained it, for the reader of the card.
    """

    weights: Mapping[str, Float32]
    activation: str
    action_low: tuple[float, ...]
    action_high: tuple[float, ...]
    algorithm: str = ""

    def act(self, observation: Float32, rng: np.random.Generator | None = None) -> Float32:
        """Actions for a batch of observations.

        Args:
            observation: (num_envs, observation_size).
            rng: Draws the actions from the policy's distribution, NOTE eq. 35; None takes their mean, NOTE eq. 36.

        Returns:
            (num_envs, action_size), in the action box.
        """
        hidden = self._hidden(observation)
        action = self._linear(hidden, "mean")
        if rng is not None:
            std = np.exp(np.clip(self._linear(hidden, "log_std"), -20.0, 2.0))
            action += std * rng.standard_normal(action.shape, dtype=np.float32)
        low, high = np.array([self.action_low, self.action_high], np.float32)
        squashed: Float32 = low + np.float32(0.5) * (np.tanh(action) + np.float32(1.0)) * (high - low)
        clipped: Float32 = np.minimum(np.maximum(squashed, low), high)  # high - low is rounded
        return clipped

    def save(self, folder: Path) -> None:
        """Write the weights and the card into `folder`, which is made."""
        folder.mkdir(parents=True, exist_ok=True)
        # safetensors writes the memory as it lies: a transposed view would come back scrambled.
        weights = {name: np.ascontiguousarray(weight) for name, weight in self.weights.items()}
        safetensors.numpy.save_file(weights, folder / WEIGHTS)
        card: dict[str, Any] = {
            "format": FORMAT,
            "kind": "squashed-gaussian-mlp",
            "algorithm": self.algorithm,
            "activation": self.activation,
            "observation_size": int(self._first_layer().shape[1]),
            "action_low": list(self.action_low),
            "action_high": list(self.action_high),
        }
        (folder / CARD).write_text(json.dumps(card, indent=1) + "\n")

    @classmethod
    def load(cls, folder: Path) -> "Policy":
        """The policy that `save` wrote.

        Raises:
            SchemaError: The folder holds no policy of a format that this version reads.
        """
        try:
            card = json.loads((folder / CARD).read_text())
            if card["format"] > FORMAT:
                raise SchemaError(f"{folder / CARD} has format {card['format']}, this version reads up to {FORMAT}")
            weights = safetensors.numpy.load_file(folder / WEIGHTS)
            low, high = tuple(card["action_low"]), tuple(card["action_high"])
            policy = cls(weights, card["activation"], low, high, card["algorithm"])
            policy._require_parts()
            return policy
        except (OSError, ValueError, KeyError, TypeError, safetensors.SafetensorError) as error:
            raise SchemaError(f"{folder} holds no readable policy: {error}") from error

    def _require_parts(self) -> None:
        """Raises KeyError for an activation or an array that `act` would miss."""
        _ = ACTIVATIONS[self.activation]
        hidden = sorted({name.rpartition(".")[0] for name in self.weights if name.startswith("hidden.")})
        for layer in (*hidden, "mean", "log_std"):
            _ = self.weights[f"{layer}.weight"], self.weights[f"{layer}.bias"]

    def _hidden(self, observation: Float32) -> Float32:
        activation, hidden = ACTIVATIONS[self.activation], observation
        for index in range(sum(name.startswith("hidden.") for name in self.weights) // 2):
            hidden = activation(self._linear(hidden, f"hidden.{index}"))
        return hidden

    def _linear(self, values: Float32, layer: str) -> Float32:
        return values @ self.weights[f"{layer}.weight"].T + self.weights[f"{layer}.bias"]

    def _first_layer(self) -> Float32:
        return self.weights.get("hidden.0.weight", self.weights["mean.weight"])
