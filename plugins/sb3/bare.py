"""A training by stable-baselines3 alone. `harness bench` compares the speed of the harness with it."""

from collections.abc import Callable
from functools import partial
from typing import Any

import torch
from stable_baselines3.common.vec_env import DummyVecEnv


def bare_training(library: Any, env: Any, steps: int, seed: int, **settings: Any) -> Callable[[], None]:
    """A function that trains a new model of the library's class at each call, without the harness.

    Args:
        library: The class, such as `stable_baselines3.SAC`.
        env: A `gymnasium.Env`, or a list of them, which the library steps one after another.
        steps: How many of their steps a training takes, over all envs.
        seed: The seed of the model.
        settings: Further keyword arguments of the class.
    """
    torch.set_num_threads(1)
    joined = side_by_side(env)

    def run() -> None:
        library("MlpPolicy", joined, seed=seed, device="cpu", **settings).learn(steps)

    return run


def side_by_side(env: Any) -> Any:
    """A list of envs as the library's one env of several; any other env as it is."""
    return DummyVecEnv([partial(_same, one) for one in env]) if isinstance(env, list) else env


def _same(env: Any) -> Any:
    return env
