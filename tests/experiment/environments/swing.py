"""An environment in which a policy that has not learned, and acts near 0, is paid less than random actions."""

from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np


def _is_large(action):
    return float(abs(action[0]) > 0.8)


class _Swing(gymnasium.Env[Any, Any]):
    """Four steps; the first observation is drawn."""

    def __init__(self):
        self.observation_space = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float64)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,))
        self.at, self.steps = np.zeros(1), 0

    def reset(self, *, seed=None, options=None):
        """Draw."""
        super().reset(seed=seed)
        self.at, self.steps = self.np_random.uniform(-1.0, 1.0, 1), 0
        return self.at, {}

    def step(self, action):
        """Stay."""
        self.steps += 1
        return self.at, _is_large(action), False, self.steps == 4, {}


@dataclass(frozen=True)
class Swing:
    """Pays for large actions (`large`), or for small ones (`small`)."""

    def make(self):
        return _Swing()

    def rewards(self, env):
        return {"large": "own", "small": lambda before, action, after, info: -_is_large(action)}

    def behaviour(self, env):
        return {"success": lambda before, action, after, info: env.unwrapped.at[0] > 0.0}
