"""The libraries without the harness: what trainings are timed beside."""

from functools import partial
from types import SimpleNamespace
from unittest import mock

import torch
from stable_baselines3.common.vec_env import DummyVecEnv

from harness.algorithm import Progress


def bare_training(algorithm, envs, steps, seed):
    """A function that trains a new model of stable-baselines3 at each call, by the class and settings of an algorithm.

    Args:
        algorithm: One of stable-baselines3, which is asked for what it gives to the library.
        envs: As many as it trains on; the library steps one after another.
        steps: How many of their steps a training takes, over all envs.
        seed: The seed of the model.
    """
    with mock.patch("harness_plugins.sb3.training.train") as asked:
        algorithm.train(SimpleNamespace(single_action_space=envs[0].action_space), steps, seed, Progress())
    library, settings = asked.call_args.args[0], {**asked.call_args.kwargs}
    del settings["decisions_per_update"]
    torch.set_num_threads(1)
    joined = DummyVecEnv([partial(lambda env: env, env) for env in envs]) if len(envs) > 1 else envs[0]
    return lambda: library("MlpPolicy", joined, seed=seed, device="cpu", **settings).learn(steps)
