"""An env that counts, so that every recorded number is known."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import harness

ACTION = np.array([0.5], np.float32)

MODES = (None, *AutoresetMode)
"""One env, or a batch in each way of starting episodes."""


class Counting(gymnasium.Env[Any, Any]):
    """Observes how many steps its episode has had, pays that number, and terminates after `length` steps."""

    observation_space = Box(0, np.inf, (1,), np.float32)
    action_space = Box(-1, 1, (1,), np.float32)
    metadata = {"render_modes": []}  # noqa: RUF012 (Gymnasium declares it so)

    def __init__(self, length: int = 3, fresh: bool = False) -> None:
        self.length, self.count, self._fresh = length, 0, fresh
        self._place = np.zeros(1, np.float32)

    def reset(self, *, seed=None, options=None):
        """Count from 0; nothing is told yet."""
        super().reset(seed=seed)
        self.count = 0
        return self._observed(), {}

    def step(self, action):
        """Count on. `final` is told at the end alone, `other` never in the second step."""
        self.count += 1
        ended = self.count == self.length
        info = {"left": self.length - self.count, "words": "none"}
        info |= {"final": True} if ended else {}
        info |= {"other": 1.0} if self.count != 2 else {}
        return self._observed(), float(self.count), ended, False, info

    def _observed(self):
        self._place[0] = self.count  # the same array each time, as some envs do; Gymnasium's batches forbid it
        return self._place.copy() if self._fresh else self._place


@pytest.fixture
def counting():
    """The env; its length can be given."""
    return Counting


@pytest.fixture
def record(counting, tmp_path):
    """A recorded env, in the folder ``run``; ``own`` trains unless something else is said."""

    def make(env=None, path="run", **given):
        return recorder([lambda: env or counting()], None, tmp_path / path, **given)

    return make


def recorder(makes, mode, path, **given):
    """The envs as a recorded batch that starts episodes in this way; without a way, the first one, recorded alone."""
    given = {"trained_with": "own", "rewards": {}, **given}
    if mode is None:
        return harness.RecordRewards(makes[0](), path, **given)
    return harness.RecordVectorRewards(SyncVectorEnv(makes, autoreset_mode=mode), path, **given)


def take(env, actions, mode):
    """Steps through an env, or through a batch in any way of starting episodes, and closes it.

    Returns whether each env was stepped in each call, and not only reset.
    """
    env.reset(seed=0)
    ended, stepped = np.zeros(1 if mode is None else env.num_envs, bool), []
    for action in actions:
        stepped.append(~ended | (mode != AutoresetMode.NEXT_STEP))
        _, _, terminated, truncated, _ = env.step(action)
        ended = np.atleast_1d(terminated) | truncated
        if ended.any() and mode in (None, AutoresetMode.DISABLED):
            env.reset(options=mode and {"reset_mask": ended})
    env.close()
    return np.array(stepped)
