"""What acts, and the folder that it is saved in: a card in JSON, and arrays that no code is run to read."""

import hashlib
import json
from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import safetensors.numpy
from numpy.typing import NDArray

from harness.arrays import Float, Float32
from harness.errors import SchemaError
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
        SchemaError: A later version wrote it.
    """
    card = read_json(folder / CARD, MOST_CARD_BYTES)
    if card["format"] > FORMAT:
        raise SchemaError(f"{folder / CARD} has format {card['format']}, this version reads up to {FORMAT}")
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
    return np.array([_generator(row.tobytes()).random(size) for row in rows]).reshape(len(rows), size)


def _generator(seen: bytes) -> np.random.Generator:
    return np.random.default_rng(int.from_bytes(hashlib.blake2b(seen, digest_size=16).digest()))


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
