"""Soft actor-critic by other libraries, with our settings. `harness bench` compares our speed with theirs."""

import os
from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from harness.errors import UsageError

from .soft_actor_critic import SoftActorCritic

ONE_THREAD = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
"""Flags for XLA, the compiler of JAX: one thread, as in every training that is timed here."""


def soft_actor_critics(settings: SoftActorCritic) -> Mapping[str, Callable[[Any, int, int], Callable[[], None]]]:
    """A training with each library, by the library's name; see ``peer_trainings`` of `harness.algorithm.Algorithm`."""
    return {
        "stable-baselines3": lambda env, steps, seed: _with_torch(settings, env, steps, seed),
        "sbx": lambda env, steps, seed: _with_jax(settings, env, steps, seed),
    }


def _with_torch(settings: SoftActorCritic, env: Any, steps: int, seed: int) -> Callable[[], None]:
    _require("stable_baselines3", "pip install 'fd100-harness[sb3]'")
    from .sb3.bare import bare_training
    from .sb3.training import soft_actor_critic_settings

    library = import_module("stable_baselines3").SAC
    return bare_training(library, env, steps, seed, **soft_actor_critic_settings(settings, steps))


def _with_jax(settings: SoftActorCritic, env: Any, steps: int, seed: int) -> Callable[[], None]:
    """A training with sbx. Every call goes on with the same model.

    The library would compile again for each new model, which takes longer than a short training.
    """
    _require("sbx", "pip install sbx-rl")
    from .sb3.bare import side_by_side

    os.environ["XLA_FLAGS"] = f"{os.environ.get('XLA_FLAGS', '')} {ONE_THREAD}"  # JAX reads it when it is imported
    library = import_module("sbx").SAC
    same = ("learning_rate", "gamma", "batch_size", "learning_starts", "train_freq", "gradient_steps", "tau")
    given = {name: getattr(settings, name) for name in same}
    coefficient = settings.ent_coef if settings.learns_coefficient else settings.first_coefficient
    network = {"net_arch": list(settings.net_arch)}
    model = library(
        "MlpPolicy",
        side_by_side(env),
        seed=seed,
        buffer_size=100 * steps,
        ent_coef=coefficient,
        policy_kwargs=network,
        **given,
    )

    def run() -> None:
        model.learning_starts = model.num_timesteps + settings.learning_starts  # as many updates as a new model does
        model.learn(steps, reset_num_timesteps=False)

    return run


def _require(package: str, remedy: str) -> None:
    if find_spec(package) is None:
        raise UsageError(f"{package} is not installed: {remedy}")
