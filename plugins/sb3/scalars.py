"""Numbers to watch, by the names that they have in Unity ML-Agents' statistics."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

NAMES = {
    "train/actor_loss": ("Losses/Policy Loss", 1.0),
    "train/policy_gradient_loss": ("Losses/Policy Loss", 1.0),
    "train/critic_loss": ("Losses/Value Loss", 1.0),
    "train/value_loss": ("Losses/Value Loss", 1.0),
    "train/loss": ("Losses/Value Loss", 1.0),
    "train/entropy_loss": ("Policy/Entropy", -1.0),
    "train/ent_coef": ("Policy/Continuous Entropy Coeff", 1.0),
    "train/learning_rate": ("Policy/Learning Rate", 1.0),
    "rollout/exploration_rate": ("Policy/Epsilon", 1.0),
}
"""Of the library's logger, each with its name here and a factor."""


class Scalars:
    """Gathers what the episodes brought until it is taken; ``Episode Length`` is in decisions."""

    def __init__(self) -> None:
        self._returns: list[float] = []
        self._lengths: list[int] = []

    def watch(self, infos: Sequence[Mapping[str, Any]], dones: NDArray[np.bool_]) -> None:
        """A step of every env was made."""
        for k in np.flatnonzero(dones):
            self._returns.append(infos[k]["episode"]["r"])
            self._lengths.append(infos[k]["episode"]["l"])

    def take(self, logged: Mapping[str, Any]) -> dict[str, float]:
        """Means over the episodes that ended since the last time, if any did, and the last of what was logged."""
        values: dict[str, float] = {}
        if self._returns:
            values["Environment/Cumulative Reward"] = float(np.mean(self._returns))
            values["Environment/Episode Length"] = float(np.mean(self._lengths))
        self._returns, self._lengths = [], []
        losses = _without_totals(logged)
        return values | {name: factor * float(logged[key]) for key, (name, factor) in NAMES.items() if key in losses}


def _without_totals(logged: Mapping[str, Any]) -> set[str]:
    """Of PPO, ``train/loss`` is the sum of its terms; of DQN it is the one there is."""
    return {key for key in logged if key != "train/loss" or "train/value_loss" not in logged}
