"""What is written down of an env beside its steps: its spec and versions, and nothing of the machine."""

import json
import platform
import sys
from collections.abc import Collection, Mapping
from typing import Any

import gymnasium
import numpy as np
import pyarrow as pa
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector import SyncVectorEnv

import harness

LEARNERS = ("stable_baselines3", "sb3_contrib", "sbx", "torch", "jax", "ray")
"""Their versions are noted where something has imported them."""


def env_facts(env: Any) -> dict[str, Any]:
    """Class, id, arguments, horizon and wrappers of an env, single or vector, as JSON has them."""
    kind, spec = type(env.unwrapped), env.spec or _first_spec(env.unwrapped)
    facts: dict[str, Any] = {"class": f"{kind.__module__}.{kind.__qualname__}", "wrappers": _wrappers(env)}
    if spec is not None:
        facts |= {"id": spec.id, "kwargs": plain(spec.kwargs), "max_episode_steps": spec.max_episode_steps}
    return facts


def _first_spec(env: Any) -> EnvSpec | None:
    """The spec of the first env of a batch that was made of single envs."""
    return env.envs[0].spec if isinstance(env, SyncVectorEnv) else None


def _wrappers(env: Any) -> list[str]:
    """Names of their classes, the outermost first."""
    names = []
    while isinstance(env, (gymnasium.Wrapper, gymnasium.vector.VectorWrapper)):
        names.append(type(env).__name__)
        env = env.env
    return names


def normalises(facts: Mapping[str, Any]) -> bool:
    """Whether a wrapper normalises observations by those that it has seen, so that equal starts look different."""
    return any("Normalize" in name for name in facts["wrappers"])


def plain(value: Any) -> Any:
    """`value` as JSON has it; of what JSON has not, the name of its class: no address, no place on a disk."""
    if isinstance(value, dict):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(inner) for inner in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist())
    try:
        json.dumps(value, allow_nan=False)
    except (TypeError, ValueError):
        return repr(value) if isinstance(value, float) else f"{type(value).__module__}.{type(value).__qualname__}"
    return value


def versions_of(env: Any, learners: Collection[str] = LEARNERS) -> dict[str, str]:
    """The versions of Python, of what records, of the env's package and of those `learners` that are loaded."""
    home = type(env.unwrapped).__module__.partition(".")[0]
    loaded = {name: getattr(sys.modules.get(name), "__version__", None) for name in (home, *learners)}
    return {
        "python": platform.python_version(),
        "fd100-harness": harness.__version__,
        "gymnasium": gymnasium.__version__,
        "numpy": np.__version__,
        "pyarrow": pa.__version__,
        **{name: str(version) for name, version in loaded.items() if version is not None},
    }
