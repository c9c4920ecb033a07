"""A boat that docks: observations are dicts, and it draws itself; and one whose waves no seed tells."""

from dataclasses import dataclass

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict


class Boat(gymnasium.Env):
    """Moves on a plane towards a dock, which is drawn anew for each episode."""

    metadata = {"render_modes": ["rgb_array"]}  # noqa: RUF012
    observation_space = Dict({"at": Box(-9, 9, (2,), np.float64), "dock": Box(-9, 9, (2,), np.float64)})
    action_space = Box(-1, 1, (2,), np.float32)

    def __init__(self, waves):
        self.waves, self.render_mode = waves, None

    def reset(self, **options):
        super().reset(**options)
        self.at, self.dock = np.zeros(2), self.np_random.uniform(-1, 1, 2)
        return self._seen(), {}

    def step(self, action):
        self.at = self.at + 0.1 * np.asarray(action, float) + self.waves * np.random.default_rng().normal(size=2)
        far = float(np.linalg.norm(self.at - self.dock))
        return self._seen(), -far, far < 0.05, False, {}

    def render(self):
        picture = np.full((20, 30, 3), 255, np.uint8)
        x, y = np.clip(10 + 5 * self.at, 0, 19).astype(int)
        picture[y, x] = 0
        return picture

    def _seen(self):
        return {"at": self.at.copy(), "dock": self.dock.copy()}


def near(observation, action, next_observation, info):
    """Pays for being near; two terms."""
    far = float(np.linalg.norm(next_observation["at"] - next_observation["dock"]))
    return {"near": 1.0 - far, "effort": -0.01 * float(np.square(action).sum())}


def docked(observation, action, next_observation, info):
    """Whether the boat is at the dock."""
    return float(np.linalg.norm(next_observation["at"] - next_observation["dock"])) < 0.05


@dataclass(frozen=True)
class Docking:
    """The environment.

    Attributes:
        waves: How far unseeded waves push, each step.
    """

    waves: float = 0.0

    def make(self):
        """An env of 12 steps."""
        return gymnasium.wrappers.TimeLimit(Boat(self.waves), 12)

    def rewards(self, env):
        """One with terms."""
        return {"near": near}

    def behaviour(self, env):
        """Whether it docks."""
        return {"success": docked}
