"""What acts."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float32
from harness.policy.folder import write_folder

Action = NDArray[Any]


class Policy(ABC):
    """Turns observations into actions, NOTE definition 3; each kind is a frozen dataclass.

    Arrays are kept as they are given: do not change them once the policy acts.

    Attributes:
        kind: Its name on the card of a saved policy; see `harness.policy.kinds`.
        weights: Its arrays by name, float32.
        algorithm: What trained it, for the reader of the card.
    """

    kind: ClassVar[str]
    weights: Mapping[str, Float32]
    algorithm: str

    @abstractmethod
    def act(self, observation: Float32, rng: np.random.Generator | None = None) -> Action:
        """Actions for a batch of observations.

        Args:
            observation: (num_envs, observation_size).
            rng: Draws the actions, NOTE eq. 35; None takes the one action of each observation, NOTE eq. 36.

        Returns:
            (num_envs, action_size) of float32 in the action box, or (num_envs,) of int64 below the number of choices.
        """

    @abstractmethod
    def floor(self) -> "Policy":
        """The policy for the same actions that chooses among them uniformly."""

    @abstractmethod
    def card(self) -> dict[str, Any]:
        """All that `from_card` needs beside the arrays, as plain JSON."""

    @classmethod
    @abstractmethod
    def from_card(cls, card: Mapping[str, Any], weights: Mapping[str, Float32]) -> "Policy":
        """The policy that a card of this kind describes.

        Raises:
            KeyError: The card or the weights lack something that `act` needs.
            ValueError: Something there cannot be, or does not fit the rest.
        """

    def save(self, folder: Path, cell: Mapping[str, Any] | None = None) -> None:
        """Write the weights and the card into `folder`, which is made.

        Args:
            folder: Where to.
            cell: The training cell, `harness.record.cell.Cell.to_json`, for the reader of the card.
        """
        own = {"kind": self.kind, "algorithm": self.algorithm, **self.card()}
        write_folder(folder, {**own, "cell": cell}, self.weights)
