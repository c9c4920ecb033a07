"""Wrappers that change what an env pays, or what is observed: on which side of the recorder they stand decides."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import gymnasium
from gymnasium.vector import SyncVectorEnv, VectorRewardWrapper, VectorWrapper
from gymnasium.wrappers import NormalizeObservation, NormalizeReward
from gymnasium.wrappers.vector import (
    NormalizeObservation as VectorNormalizeObservation,
    NormalizeReward as VectorNormalizeReward,
)

from harness.errors import HarnessError, UsageError
from harness.record.recording.recorded_training import read_facts
from harness.recorder.computing import used_by

NORMALISED = "NormalizeObservation"
"""The wrapper's name in recordings, `harness.recorder.env_facts`."""
PAY = (gymnasium.RewardWrapper, VectorRewardWrapper, NormalizeReward, VectorNormalizeReward)


def tell_wrapped_pay(env: Any, recorder: str, pays: bool) -> list[str]:
    """What is to be told of wrappers inside the recorder that change what the env pays.

    Args:
        env: What is recorded.
        recorder: The name of the class that records.
        pays: Whether the recorder pays the learner.

    Raises:
        UsageError: It does, and such a wrapper of Gymnasium would scale what the env itself pays and no other reward.
    """
    told = []
    for wrapper in _wrappers(env):
        name, is_own = type(wrapper).__name__, not type(wrapper).__module__.startswith("gymnasium.")
        if not isinstance(wrapper, PAY):
            continue
        if pays and not is_own:
            raise UsageError(
                f"{name} stands inside {recorder}(..., pay=True): it changes what the env pays, and not the other "
                f"rewards, so their trainings could not be compared. Put it outside: "
                f"{name}({recorder}(env, ..., pay=True))"
            )
        if pays:
            told.append(f"{name} stands inside the recorder: 'own' is what it makes of the pay, and no other reward is")
        elif isinstance(wrapper, NormalizeReward | VectorNormalizeReward):
            told.append(
                f"{name} stands inside the recorder: 'own' is in units that change from step to step. Put it outside: "
                f"{name}({recorder}(env, ...))"
            )
    return told


def tell_normalisation(env: Any, path: Path, policy: Callable[[Any], Any]) -> list[str]:
    """What is to be told of observations that were normalised in the training, and are otherwise in an evaluation.

    Args:
        env: In which the policy acts.
        path: The folder of the evaluation; where it lies in that of the training, this tells its wrappers.
        policy: One that holds a model of stable-baselines3 tells of the model's ``VecNormalize``.
    """
    inside = [it for it in _wrappers(env) if isinstance(it, NormalizeObservation | VectorNormalizeObservation)]
    if any(it.update_running_mean for it in inside):
        return [
            f"{NORMALISED} of the evaluation goes on with means of its own. Give it those of the training: "
            "env.obs_rms = trained.obs_rms, env.update_running_mean = False"
        ]
    if not inside and NORMALISED in _wrappers_of_training(path):
        return [
            f"the training's observations were normalised ({NORMALISED}), and those of the evaluation are not. Wrap "
            "its env too: env.obs_rms = trained.obs_rms, env.update_running_mean = False"
        ]
    held = list(used_by(policy))
    for model in held:
        ask = getattr(model, "get_vec_normalize_env", None)
        normalize = ask() if callable(ask) and not isinstance(model, type) else None
        if getattr(normalize, "norm_obs", False) and not inside and not any(it is normalize for it in held):
            return [
                "the model was trained with VecNormalize, and this policy gets observations as they are. Write "
                "vec = model.get_vec_normalize_env() and lambda seen: model.predict(vec.normalize_obs(seen))[0]"
            ]
    return []


def _wrappers_of_training(path: Path) -> list[str]:
    """Names of the wrappers of the training in whose folder an evaluation lies, if it lies in one."""
    try:
        facts = read_facts(path.parent)
    except (HarnessError, OSError):
        return []
    return [] if facts.evaluation else list(facts.spec.get("wrappers", ()))


def _wrappers(env: Any) -> Iterator[Any]:
    """The outermost first; of a batch of single envs, then those of the first of them."""
    while isinstance(env, gymnasium.Wrapper | VectorWrapper):
        yield env
        env = env.env
    if isinstance(env, SyncVectorEnv):
        yield from _wrappers(env.envs[0])
