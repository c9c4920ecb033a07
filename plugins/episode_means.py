"""What episodes brought while a policy learned."""

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Mask
from harness.progress import TrainingState, as_state


class EpisodeMeans:
    """Gathers returns and lengths of the episodes of `num_envs` envs until they are taken; lengths are in decisions."""

    def __init__(self, num_envs: int) -> None:
        self._return, self._length = np.zeros(num_envs), np.zeros(num_envs, int)
        self._returns: list[float] = []
        self._lengths: list[int] = []

    def watch(self, rewards: NDArray[np.floating], ended: Mask) -> None:
        """A decision was made in every env, which ended an episode or not, (num_envs,) each."""
        self._return += rewards
        self._length += 1
        if ended.any():
            self._returns += self._return[ended].tolist()
            self._lengths += self._length[ended].tolist()
            self._return[ended], self._length[ended] = 0.0, 0

    def state(self) -> TrainingState:
        """All that `restore` needs."""
        return as_state(
            {"return": self._return, "length": self._length, "returns": self._returns, "lengths": self._lengths}
        )

    def restore(self, state: TrainingState) -> None:
        """Be where `state` was told."""
        self._return[...], self._length[...] = state["return"], state["length"]
        self._returns, self._lengths = state["returns"].tolist(), state["lengths"].tolist()

    def take(self) -> dict[str, float]:
        """Means over the episodes that ended since the last time, if any did, by Unity ML-Agents' names."""
        if not self._returns:
            return {}
        means = {
            "Environment/Cumulative Reward": float(np.mean(self._returns)),
            "Environment/Episode Length": float(np.mean(self._lengths)),
        }
        self._returns, self._lengths = [], []
        return means
