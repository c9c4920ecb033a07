"""An environment of a few numbers, as a plugin file: a point on a line, paid for being near or for being right."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import gymnasium
import numpy as np


class _Line(gymnasium.Env[Any, Any]):
    """A point moves for eight steps; what it observes is a dict."""

    metadata: ClassVar[dict[str, Any]] = {"render_modes": ["rgb_array"]}

    def __init__(self, discrete=False, endless=False):
        box = gymnasium.spaces.Box(-np.inf, np.inf, (1,), np.float64)
        self.observation_space = gymnasium.spaces.Dict({"at": box, "left": gymnasium.spaces.Discrete(9)})
        self.action_space = gymnasium.spaces.Discrete(3) if discrete else gymnasium.spaces.Box(-1.0, 1.0, (1,))
        self.at, self.steps, self.endless = 0.0, 0, endless

    def reset(self, *, seed=None, options=None):
        """Start at random."""
        super().reset(seed=seed)
        self.at, self.steps = float(self.np_random.uniform(-1.0, 1.0)), 0
        return self._observed(), {}

    def step(self, action):
        """Move."""
        self.at += float(np.sum(action)) if isinstance(self.action_space, gymnasium.spaces.Box) else int(action) - 1
        self.steps += 1
        terminated, truncated = (not self.endless and it for it in (abs(self.at) > 4.0, self.steps == 8))
        return self._observed(), -abs(self.at), terminated, truncated, {"distance": abs(self.at)}

    def render(self):
        """White where the point is, if it is told to draw so."""
        if self.render_mode != "rgb_array":
            return None
        picture = np.zeros((40, 40, 3), np.uint8)
        picture[:, int(np.clip(20 + 4 * self.at, 0, 39))] = 255
        return picture

    def _observed(self):
        return {"at": np.array([self.at]), "left": max(0, 8 - self.steps)}


@dataclass(frozen=True)
class Toy:
    """A point on a line; `endless` where no episode ends."""

    discrete: bool = False
    endless: bool = False

    lower_is_better: ClassVar[frozenset[str]] = frozenset({"distance"})
    bounds: ClassVar[Mapping[str, tuple[float, float]]] = {"distance": (0.0, np.inf)}

    def make(self):
        return _Line(self.discrete, self.endless)

    def rewards(self, env):
        return {"near": "own", "right": lambda before, action, after, info: env.unwrapped.at}

    def behaviour(self, env):
        return {"distance": "distance", "success": lambda before, action, after, info: abs(env.unwrapped.at) < 0.5}
