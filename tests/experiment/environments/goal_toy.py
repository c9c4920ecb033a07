"""An environment with goals, as a plugin file: a point in a square has to come to another one."""

from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict
from numpy.linalg import norm

NEAR, LASTS = 0.2, 8


class _Square(gymnasium.Env[Any, Any]):
    """A point moves in a square for eight steps, by at most 0.25 a step and axis; within 0.2 it is there."""

    def __init__(self):
        box = Box(-1.0, 1.0, (2,), np.float64)
        self.observation_space = Dict({"achieved_goal": box, "desired_goal": box, "observation": box})
        self.action_space = Box(-1.0, 1.0, (2,), np.float32)
        self.at, self.before, self.goal, self.steps = np.zeros(2), np.zeros(2), np.zeros(2), 0

    def reset(self, *, seed=None, options=None):
        """Start in the middle; the goal is anywhere."""
        super().reset(seed=seed)
        self.at, self.before, self.steps = np.zeros(2), np.zeros(2), 0
        self.goal = self.np_random.uniform(-1.0, 1.0, 2)
        return self._observed(), {}

    def step(self, action):
        """Move."""
        self.before = self.at
        self.at = np.clip(self.at + 0.25 * np.asarray(action, float), -1.0, 1.0)
        self.steps += 1
        paid = float(self.compute_reward(self.at, self.goal, {}))
        return self._observed(), paid, False, self.steps == LASTS, {"success": paid == 0.0}

    def compute_reward(self, achieved, desired, info):
        """0 where it is there, -1 elsewhere."""
        return -(norm(achieved - desired, axis=-1) > NEAR).astype(float)

    def _observed(self):
        return {"achieved_goal": self.at.copy(), "desired_goal": self.goal.copy(), "observation": self.at - self.before}


@dataclass(frozen=True)
class GoalToy:
    """A point in a square."""

    lies: bool = False

    def make(self):
        return _Square()

    def rewards(self, env):
        return {"there": "own", "slow": lambda before, action, after, info: -float(np.abs(action).sum())}

    def goal_rewards(self, env):
        arm = env.unwrapped
        return {"there": lambda achieved, desired: arm.compute_reward(achieved, desired, {}) - self.lies}

    def behaviour(self, env):
        return {"success": "success"}
