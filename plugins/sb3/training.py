"""A training by stable-baselines3, on the CPU, with one thread."""

from collections.abc import Callable
from typing import Any

import torch
from gymnasium.spaces import Dict
from stable_baselines3.common.logger import Logger

from harness.algorithm import Progress, TrainingEnv, under
from harness.policy import Policy

from .callback import ProgressCallback, steps_done
from .state import restore_model
from .vec_env import VecEnvAdapter

ACTIVATIONS = {"relu": torch.nn.ReLU, "tanh": torch.nn.Tanh}


def train(
    library: Any,
    env: TrainingEnv,
    steps: int,
    seed: int,
    progress: Progress,
    policy_of: Callable[[Any], Policy],
    decisions_per_update: int,
    adapter: type[VecEnvAdapter] = VecEnvAdapter,
    **settings: Any,
) -> Policy:
    """Train a class of the library for `steps` environment steps and yield the policy.

    Args:
        library: The class, such as `stable_baselines3.SAC`.
        env: See `harness.algorithm.Algorithm.train`.
        steps: The same.
        seed: The same.
        progress: The same.
        policy_of: A function of a model, which returns its present policy.
        decisions_per_update: Decisions between two updates, over all envs.
        adapter: Makes the library's env from `env`.
        settings: Further keyword arguments of the class.
    """
    # One thread is faster than two that wait for each other, and its sums are always the same.
    torch.set_num_threads(1)
    # A learner that loses its numbers is told by its action, in our words and not in torch's.
    torch.distributions.Distribution.set_default_validate_args(False)
    state = progress.restored()
    before = env.environment_steps - steps_done(state)

    class Model(library):  # type: ignore[misc]
        def _update_current_progress_remaining(self, num_timesteps: int, total_timesteps: int) -> None:
            """Let schedules end with the budget of environment steps. The library would count decisions."""
            super()._update_current_progress_remaining(env.environment_steps - before, steps)

    adapted = adapter(env)
    policy = "MultiInputPolicy" if isinstance(adapted.observation_space, Dict) else "MlpPolicy"
    model = Model(policy, adapted, seed=seed % 2**32, device="cpu", **settings)
    if state is not None:
        restore_model(model, under("model.", state))
    model.set_logger(Logger(None, []))  # the library's own would make a folder for temporary files, and leave it
    callback = ProgressCallback(env, progress, steps, policy_of, decisions_per_update, state)
    is_new = state is None
    del state  # it holds a second replay buffer
    # Without log_interval the logger keeps the last losses for `progress`. The library counts the steps that are left
    # to do, from where the model stands.
    model.learn(steps - model.num_timesteps, callback=callback, log_interval=None, reset_num_timesteps=is_new)
    return policy_of(model)


REPLAY = ("learning_rate", "gamma", "batch_size", "learning_starts", "train_freq", "gradient_steps", "tau")


def replay_settings(settings: Any, steps: int) -> dict[str, Any]:
    """The keyword arguments of every class that learns from a replay buffer, for `steps` environment steps."""
    return {
        **{name: getattr(settings, name) for name in REPLAY},
        "buffer_size": min(settings.buffer_size, steps),
        "policy_kwargs": network(settings.net_arch, settings.activation),
    }


def soft_actor_critic_settings(settings: Any, steps: int) -> dict[str, Any]:
    """The keyword arguments of `stable_baselines3.SAC`, for `steps` environment steps."""
    coefficient = settings.ent_coef if settings.learns_coefficient else settings.first_coefficient
    return {**replay_settings(settings, steps), "ent_coef": coefficient}


def network(layers: tuple[int, ...], activation: str) -> dict[str, Any]:
    """The library's ``policy_kwargs`` for networks with these hidden layers."""
    return {"net_arch": list(layers), "activation_fn": ACTIVATIONS[activation]}
