"""One cell of the matrix: everything that decides what a training run does."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from harness.choice import Choice


@dataclass(frozen=True)
class Cell:
    """One training run, to be done or done.

    Attributes:
        simulator: Whose engine moves the arm.
        robot: Registered name or folder of the arm.
        task: What the arm has to do.
        algorithm: What learns.
        reward: What it is paid for.
        seed: Of the starts, the targets and the algorithm. Equal seeds meet equal starts and targets, whatever the
            reward or the algorithm.
        steps: Environment steps of training.
        evaluation_episodes: Episodes after training; the same starts and targets in every cell.
    """

    simulator: Choice
    robot: str
    task: Choice
    algorithm: Choice
    reward: Choice
    seed: int
    steps: int
    evaluation_episodes: int

    @cached_property
    def id(self) -> str:
        """A hash of the content."""
        text = json.dumps(self.to_json(), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    @property
    def title(self) -> str:
        """For people: the combination and the seed."""
        return f"{self.simulator.label} · {self.algorithm.label} · {self.reward.label} · seed {self.seed}"

    def to_json(self) -> dict[str, Any]:
        """Plain data; `from_json` gives the same cell back."""
        return {
            key: value.to_json() if isinstance(value, Choice) else value
            for key, value in vars(self).items()
            if key != "id"
        }

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> "Cell":
        """The cell that `to_json` wrote."""
        values: dict[str, Any] = {
            key: Choice.from_json(value) if isinstance(value, dict) else value for key, value in data.items()
        }
        return cls(**values)
