"""What acts."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import safetensors
from numpy.typing import NDArray

from harness.errors import SchemaError
from harness.policy.folder import read_folder, write_folder

Float32 = NDArray[np.float32]
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
            cell: The training cell, `harness.cell.Cell.to_json`, for the reader of the card.
        """
        own = {"kind": self.kind, "algorithm": self.algorithm, **self.card()}
        write_folder(folder, {**own, "cell": cell}, self.weights)

    @staticmethod
    def load(folder: Path) -> "Policy":
        """The policy that `save` wrote, of whatever kind.

        Raises:
            SchemaError: The folder holds no policy of a format that this version reads.
        """
        from harness.policy.kinds import kind_named  # it knows every kind, and every kind is a Policy

        try:
            card, weights = read_folder(folder)
            return kind_named(card["kind"]).from_card(card, weights)
        except KeyError as error:
            raise SchemaError(f"{folder} holds no readable policy: {error} is missing") from error
        except (OSError, ValueError, TypeError, AttributeError, ArithmeticError, safetensors.SafetensorError) as error:
            raise SchemaError(f"{folder} holds no readable policy: {error}") from error
