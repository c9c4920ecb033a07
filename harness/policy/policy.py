"""What acts: policies, the folder of a saved one, which no code is run to read, and those whose actions fill a box."""

import hashlib
import json
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Self, TypeAlias

import numpy as np
import safetensors.numpy
from numpy.typing import NDArray

from harness.arrays import Float, Float32
from harness.errors import NewerFormat
from harness.files.bounded import read_bytes, read_json
from harness.record.folder import CARD, WEIGHTS

FORMAT = 2
MOST_CARD_BYTES = 2**20
"""The most bytes of a card: ours have two thousand, most of them the training cell."""
MOST_WEIGHT_BYTES = 64 * 2**20
"""The most bytes of the arrays: those of three layers of 2,048, and 100 times what reaching takes."""
MOST_HEADER_BYTES = 2**20
"""The most bytes of the names and shapes before the arrays: 10,000 of them."""
Weights = Mapping[str, Float32]


def write_folder(folder: Path, card: Mapping[str, Any], weights: Weights) -> None:
    """Write `card` and `weights` into `folder`, which is made."""
    folder.mkdir(parents=True, exist_ok=True)
    # safetensors writes the memory as it lies: a transposed view would come back scrambled.
    arrays = {name: np.ascontiguousarray(weight) for name, weight in weights.items()}
    safetensors.numpy.save_file(arrays, folder / WEIGHTS)
    (folder / CARD).write_text(json.dumps({"format": FORMAT, **card}, indent=1, allow_nan=False) + "\n")


def read_folder(folder: Path) -> tuple[dict[str, Any], Weights]:
    """The card, as this format has it, and the arrays.

    Raises:
        NewerFormat: A later version wrote it.
    """
    card = read_json(folder / CARD, MOST_CARD_BYTES)
    if card["format"] > FORMAT:
        raise NewerFormat(f"{folder / CARD} has format {card['format']}, this version reads up to {FORMAT}")
    if card["format"] == 1:
        card = _from_format_1(card)
    if not isinstance(card["algorithm"], str):
        raise ValueError(f"the algorithm is {card['algorithm']!r}, no text")
    return card, _read_weights(folder / WEIGHTS)


def _read_weights(path: Path) -> Weights:
    """The arrays.

    Raises:
        ValueError: Their names alone are too many, or an array is not of float32, or has no numbers.
    """
    content = read_bytes(path, MOST_WEIGHT_BYTES)
    header = int.from_bytes(content[:8], "little")
    if header > MOST_HEADER_BYTES:
        raise ValueError(f"the header of {path.name} has {header:,} bytes, {MOST_HEADER_BYTES:,} are allowed")
    weights = safetensors.numpy.load(content)
    for name, array in weights.items():
        if array.dtype != np.float32:
            raise ValueError(f"{name} is {array.dtype}, not float32")
        if not array.size:
            raise ValueError(f"{name} has no numbers, {array.shape}")
    return weights


def _from_format_1(card: Mapping[str, Any]) -> dict[str, Any]:
    """Format 1 knew one kind, and kept sizes and bounds side by side."""
    return {
        "format": FORMAT,
        "kind": "squashed-gaussian",
        "algorithm": card["algorithm"],
        "observation": {"size": card["observation_size"]},
        "action": {"type": "continuous", "low": card["action_low"], "high": card["action_high"]},
        "activation": card["activation"],
        "normalisation": None,
        "cell": None,
    }


def scatter(observation: Float32, size: int) -> Float:
    """Uniform numbers that depend on each observation alone: not on the batch, nor on what was asked before.

    Args:
        observation: (num_envs, observation_size).
        size: How many for each.

    Returns:
        (num_envs, size), in [0, 1).
    """
    rows = np.ascontiguousarray(observation, np.float32) + np.float32(0.0)  # -0 is 0
    digests = (hashlib.blake2b(row.tobytes(), digest_size=16).digest() for row in rows)
    drawn = [np.random.default_rng(int.from_bytes(digest)).random(size) for digest in digests]
    return np.array(drawn).reshape(len(rows), size)


Action = NDArray[Any]


class Policy(ABC):
    """Turns observations into actions, NOTE definition 3. Each kind is a frozen dataclass.

    A policy keeps the arrays that it gets: do not change them afterwards.

    Attributes:
        kind: Its name on the card of a saved policy; see `harness.policy.kinds`.
        weights: Its arrays by name, float32.
        algorithm: The name of what trained it, shown to readers of the card.
    """

    kind: ClassVar[str]
    weights: Mapping[str, Float32]
    algorithm: str

    @abstractmethod
    def act(self, observation: Float32, rng: np.random.Generator | None = None) -> Action:
        """Actions for a batch of observations.

        Args:
            observation: (num_envs, observation_size).
            rng: Draws the actions at random, NOTE eq. 35. None: the actions without randomness, NOTE eq. 36.

        Returns:
            Continuous actions: (num_envs, action_size) of float32, in the action box. Discrete ones: (num_envs,) of
            int64, from 0 to the number of choices minus 1.
        """

    @abstractmethod
    def floor(self) -> "Policy":
        """A policy that draws the same kind of actions uniformly at random."""

    @abstractmethod
    def card(self) -> dict[str, Any]:
        """All that `from_card` needs beside the arrays, as plain JSON."""

    @classmethod
    @abstractmethod
    def from_card(cls, card: Mapping[str, Any], weights: Mapping[str, Float32]) -> "Policy":
        """The policy that a card of this kind describes.

        Raises:
            KeyError: The card or the weights lack something that `act` needs.
            ValueError: A value is not possible, or does not fit the others.
        """

    def save(self, folder: Path, cell: Mapping[str, Any] | None = None) -> None:
        """Make `folder` and write the weights and the card into it.

        Args:
            folder: The folder to make.
            cell: The training cell, `harness.record.cell.Cell.to_json`, shown to readers of the card.
        """
        own = {"kind": self.kind, "algorithm": self.algorithm, **self.card()}
        write_folder(folder, {**own, "cell": cell}, self.weights)


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


@dataclass(frozen=True, eq=False)
class Uniform(Policy):
    """Actions that are uniform in the box, whatever is observed; of observations of any size.

    Without a generator an action still is a function of its observation, NOTE eq. 36: a scattered one, see
    `harness.policy.policy`.

    Attributes:
        action_low: Lower end of each action, (action_size,).
        action_high: Upper end of each action, (action_size,).
        algorithm: For the reader of the card.
    """

    kind: ClassVar[str] = "uniform"

    action_low: tuple[float, ...]
    action_high: tuple[float, ...]
    algorithm: str = ""
    weights: Mapping[str, Float32] = field(default_factory=dict, init=False)

    def act(self, observation: Float32, rng: np.random.Generator | None = None) -> Float32:
        shape = len(observation), len(self.action_low)
        low, high = np.array(self.action_low), np.array(self.action_high)
        share = rng.random(shape) if rng is not None else scatter(observation, shape[1])
        action: Float32 = np.minimum(low + (high - low) * share, high).astype(np.float32)  # high - low is rounded
        return action

    def floor(self) -> "Uniform":
        return self

    def card(self) -> dict[str, Any]:
        return {"observation": {"size": None}, "action": describe_box(self.action_low, self.action_high)}

    @classmethod
    def from_card(cls, card: Mapping[str, Any], weights: Mapping[str, Float32]) -> Self:
        return cls(*box_of(card), card["algorithm"])


Ends = tuple[float, ...]
MOST_ACTIONS = 100
"""At once: an arm has one for each of its joints."""
LARGEST = 1e18
"""The largest size of an end: the difference of both ends is finite in float32."""


def describe_box(low: Ends, high: Ends) -> dict[str, Any]:
    """What a card says of the actions."""
    return {"type": "continuous", "low": list(low), "high": list(high)}


def box_of(card: Mapping[str, Any]) -> tuple[Ends, Ends]:
    """Lower and upper ends of the actions of a card.

    Raises:
        KeyError: The card does not say.
        ValueError: It says what cannot be.
    """
    action = card["action"]
    low, high = ([float(end) for end in action[key]] for key in ("low", "high"))
    if not low or len(low) != len(high):
        raise ValueError(f"the actions have {len(low)} lower and {len(high)} upper ends")
    if len(low) > MOST_ACTIONS:
        raise ValueError(f"there are {len(low):,} actions, {MOST_ACTIONS:,} are allowed")
    if not all(-LARGEST <= a <= b <= LARGEST for a, b in zip(low, high, strict=True)):  # NaN is not either
        raise ValueError(f"no action lies between {low} and {high}")
    return tuple(low), tuple(high)


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
        return Uniform(self.action_low, self.action_high)

    def card(self) -> dict[str, Any]:
        return {**super().card(), "action": describe_box(self.action_low, self.action_high)}

    @classmethod
    def from_card(cls, card: Mapping[str, Any], weights: Mapping[str, Float32]) -> Self:
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
        return {**super().card(), "noise": self.noise}

    @classmethod
    def from_card(cls, card: Mapping[str, Any], weights: Mapping[str, Float32]) -> Self:
        noise = float(card["noise"])
        if not 0.0 <= noise <= LARGEST:
            raise ValueError(f"noise is {noise}, not a number from 0 to {LARGEST:g}")
        return replace(super().from_card(card, weights), noise=noise)


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
        action = self.head(self.hidden(observation), "mean")
        if rng is not None:
            action += np.exp(self.weights[LOG_STD]) * rng.standard_normal(action.shape, dtype=np.float32)
        return self._clip(action)

    @classmethod
    def from_card(cls, card: Mapping[str, Any], weights: Mapping[str, Float32]) -> Self:
        policy = super().from_card(card, weights)
        if weights[LOG_STD].shape != (len(policy.action_low),):
            raise ValueError(f"{LOG_STD} is {weights[LOG_STD].shape}, on {len(policy.action_low)} actions")
        return policy


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
        hidden = self.hidden(observation)
        action = self.head(hidden, "mean")
        if rng is not None:
            std = np.exp(np.clip(self.head(hidden, "log_std"), -20.0, 2.0))
            action += std * rng.standard_normal(action.shape, dtype=np.float32)
        return self._squash(action)
