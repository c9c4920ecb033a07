"""What acts."""

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Float32
from harness.policy.folder import write_folder


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
