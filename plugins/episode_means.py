"""Mean return and length of the episodes that end while a policy learns."""

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Mask
from harness.progress import TrainingState, as_state


class EpisodeMeans:
    """Collects returns and lengths of the episodes that end in `num_envs` envs, until `take` returns their means.

    The length of an episode is its number of decisions.
    """

    def __init__(self, num_envs: int) -> None:
        self._return, self._length = np.zeros(num_envs), np.zeros(num_envs, int)
        self._returns: list[float] = []
        self._lengths: list[int] = []

    def watch(self, rewards: NDArray[np.floating], ended: Mask) -> None:
        """Record one decision of every env.

        Args:
            rewards: What each env paid for it, (num_envs,).
            ended: Whether it ended the env's episode, (num_envs,).
        """
        self._return += rewards
        self._length += 1
        if ended.any():
            self._returns += self._return[ended].tolist()
            self._lengths += self._length[ended].tolist()
            self._return[ended], self._length[ended] = 0.0, 0

    def state(self) -> TrainingState:
        """Everything that `restore` needs."""
        return as_state(
            {"return": self._return, "length": self._length, "returns": self._returns, "lengths": self._lengths}
        )

    def restore(self, state: TrainingState) -> None:
        """Go on from `state`, which the method of this name returned."""
        self._return[...], self._length[...] = state["return"], state["length"]
        self._returns, self._lengths = state["returns"].tolist(), state["lengths"].tolist()

    def take(self) -> dict[str, float]:
        """Means over the episodes that ended since the last call, by Unity ML-Agents' names; empty if none ended."""
        if not self._returns:
            return {}
        means = {
            "Environment/Cumulative Reward": float(np.mean(self._returns)),
            "Environment/Episode Length": float(np.mean(self._lengths)),
        }
        self._returns, self._lengths = [], []
        return means
