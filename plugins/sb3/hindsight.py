"""Hindsight experience replay by stable-baselines3: what it needs beside its `HerReplayBuffer`."""

from collections import OrderedDict
from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Dict
from stable_baselines3 import SAC

from harness import Float, Float32
from harness.algorithm import Goals

from .vec_env import VecEnvAdapter


class GoalEnvAdapter(VecEnvAdapter):
    """Shows observations as a dict with the achieved and the desired goal, in the order of the columns.

    The library puts the parts of a dict into one row, in this order. So its networks see what the env shows.
    """

    def _space(self) -> Dict:
        goals: Goals = self.env.goals  # type: ignore[attr-defined] # of an env with goals
        self._parts = _parts(goals, self.env.observation_space.shape[1])  # type: ignore[index] # a row of each env
        boxes = {name: Box(-np.inf, np.inf, (it.stop - it.start,), np.float32) for name, it in self._parts.items()}
        return Dict(OrderedDict(boxes))  # a plain dict would be sorted

    def _seen(self, observations: Float32) -> dict[str, Float32]:
        return {name: observations[..., columns] for name, columns in self._parts.items()}

    def compute_reward(self, achieved: Float32, desired: Float32, infos: Any) -> Float:
        """What steps that achieved `achieved` would be paid for the goal `desired`, (n,); goals are (n, goal_size)."""
        goals: Goals = self.env.goals  # type: ignore[attr-defined] # of an env with goals
        return np.asarray(goals.pay(achieved.astype(float), desired.astype(float)), float)

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        """See `VecEnvAdapter`. The adapter itself computes the reward."""
        if method_name == "compute_reward":
            return [self.compute_reward(*args, **kwargs)] * len(self._indices(indices))
        return super().env_method(method_name, *args, indices=indices, **kwargs)


class HindsightSAC(SAC):
    """Soft actor-critic that waits for the end of the first episode, since another goal needs a whole episode."""

    def train(self, gradient_steps: int, batch_size: int = 64) -> None:
        """Update the networks, if a whole episode is in the replay buffer."""
        buffer: Any = self.replay_buffer
        if buffer.ep_length.any():
            super().train(gradient_steps, batch_size)


def _parts(goals: Goals, size: int) -> Mapping[str, slice]:
    """The columns of both goals, and of what lies before, between and behind them, in order."""
    named = {"achieved_goal": goals.achieved, "desired_goal": goals.desired}
    parts: dict[str, slice] = {}
    end = 0
    for name, columns in sorted(named.items(), key=lambda it: it[1].start):
        if columns.start > end:
            parts[f"columns_{end}"] = slice(end, columns.start)
        parts[name], end = columns, columns.stop
    if end < size:
        parts[f"columns_{end}"] = slice(end, size)
    return parts
