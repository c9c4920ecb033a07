"""A training by stable-baselines3 alone. `harness bench` compares the speed of the harness with it."""

from collections.abc import Callable
from typing import Any

import torch


def bare_training(library: Any, env: Any, steps: int, seed: int, **settings: Any) -> Callable[[], None]:
    """A function that trains a new model of the library's class at each call, without the harness.

    Args:
        library: The class, such as `stable_baselines3.SAC`.
        env: A `gymnasium.Env`.
        steps: How many of its steps a training takes.
        seed: The seed of the model.
        settings: Further keyword arguments of the class.
    """
    torch.set_num_threads(1)

    def run() -> None:
        library("MlpPolicy", env, seed=seed, device="cpu", **settings).learn(steps)

    return run
