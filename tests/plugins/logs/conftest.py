"""An environment whose rewards the tests know, and what writes files with it."""

from typing import Any

import gymnasium
import numpy as np
import pytest


class Counted(gymnasium.Env[Any, Any]):
    """Episode i takes i + 2 steps, pays -1.25 - i / 8 for each, and succeeds if i is odd."""

    def __init__(self) -> None:
        self.observation_space = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float32)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float32)
        self._episode, self._step = -1, 0

    def reset(self, **kwargs):
        """Begin the next episode."""
        super().reset(seed=kwargs.get("seed"))
        self._episode, self._step = self._episode + 1, 0
        return np.zeros(1, np.float32), {}

    def step(self, action):
        """Pay, and end after so many steps."""
        self._step += 1
        info = {"is_success": self._episode % 2 == 1, "distance": 0.5 * self._episode, "phase": "reach"}
        ends = self._step == self._episode + 2
        return np.zeros(1, np.float32), -1.25 - self._episode / 8, ends, False, info


def returns_of(episodes):
    """Returns of episodes of `Counted`, by their numbers."""
    return [(-1.25 - episode / 8) * (episode + 2) for episode in episodes]


@pytest.fixture
def counted():
    """Makes the environment."""
    return Counted


@pytest.fixture
def counted_returns():
    """Returns of its episodes, by their numbers."""
    return returns_of
