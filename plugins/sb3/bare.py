"""A training by stable-baselines3 alone: what one through the harness is timed beside."""

from collections.abc import Callable
from typing import Any

import torch


def bare_training(library: Any, env: Any, steps: int, seed: int, **settings: Any) -> Callable[[], None]:
    """What trains a new model of the library's class each time it is called, with nothing of the harness around it.

    Args:
        library: The class, such as `stable_baselines3.SAC`.
        env: A `gymnasium.Env`.
        steps: How many of its steps a training takes.
        seed: Of the model.
        settings: What the class is made with, besides.
    """
    torch.set_num_threads(1)

    def run() -> None:
        library("MlpPolicy", env, seed=seed, device="cpu", **settings).learn(steps)

    return run
