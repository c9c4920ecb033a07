"""A built-in algorithm that leaves anything out of its checkpoints is found by the checks."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from harness.algorithm import needs_goals
from harness.env import ReachVectorEnv
from harness.policy import Policy
from harness.progress import Progress, Ring, TrainingState
from harness.registry.registry import load_registry
from harness_plugins.kit.algorithms import a_training_goes_on_where_it_stood, checkpoints_change_nothing

REGISTRY = load_registry()
SMALL: dict[str, Any] = {"net_arch": (8,), "batch_size": 16}
SELDOM: dict[str, Any] = {**SMALL, "learning_starts": 50, "train_freq": 5}
SETTINGS: dict[str, dict[str, Any]] = {
    "sac-fast": {**SMALL, "learning_starts": 125, "buffer_size": 100, "train_freq": 3},
    "spg": {"net_arch": (8,), "decisions": 7, "num_envs": 4, "restart": 3},
    "ppo": {**SMALL, "rollout": 64, "schedule": "linear", "num_envs": 2},
    "dqn": {**SELDOM, "tau": 0.5, "target_update_interval": 7},
    "ddqn": SELDOM,
    "td3": {**SELDOM, "policy_delay": 3},
    "sb3-sac": {**SELDOM, "buffer_size": 100},
    "her": {**SELDOM, "buffer_size": 100},
}
"""Small ones, which use all that they keep: buffers that are full, delays that no checkpoint divides."""
NEEDED = {
    "sac-fast": (
        "rng", "observation", "rounds", "decisions", "replay", "learner.targets", "learner.actor.parameters",
        "learner.actor.first", "learner.critics.second", "learner.critics.steps", "learner.coefficient.first",
        "learner.coefficient.value",
    ),
    "spg": ("rng", "observation", "updates", "policy.log_std", "policy.adam.0.exp_avg", "baseline.adam.1.exp_avg_sq"),
    "ppo": ("model.policy.optimizer.0.exp_avg", "model._last_obs", "done"),
    "dqn": ("model._n_calls", "model.exploration_rate", "model.policy.q_net_target.q_net.0.weight", "model.actions"),
    "td3": ("model._n_updates", "model.policy.actor_target.mu.0.weight", "model.numpy.rest", "done"),
    "sb3-sac": (
        "model.torch", "model.replay", "model.actor.optimizer.0.exp_avg", "model.numpy.keys", "model._last_obs",
        "model.num_timesteps", "model.policy.actor.mu.weight", "model.policy.critic_target.qf0.0.bias",
        "model.critic.optimizer.1.exp_avg_sq", "model.ent_coef_optimizer.0.exp_avg", "model.variable.log_ent_coef",
    ),
    "her": (
        "model.replay", "model.episodes.ep_length", "model.episodes._current_ep_start", "model._last_obs.columns_0",
    ),
}  # fmt: skip
"""Of what each keeps, one of every sort."""
BY_SB3 = ("ppo", "dqn", "ddqn", "td3", "sb3-sac", "her")
"""One thing of each shows in every run that the check sees through the library; the others are slow ones."""
CASES = [
    pytest.param(algorithm, name, marks=[pytest.mark.slow] * (algorithm in BY_SB3 and index > 0))
    for algorithm, names in NEEDED.items()
    for index, name in enumerate(names)
]


class Spoiling(Progress):
    """Hands on checkpoints with one thing spoiled."""

    def __init__(self, inner: Progress, name: str) -> None:
        self._inner, self._name = inner, name

    def checkpoint(self, steps: int, make: Callable[[], TrainingState]) -> None:
        def spoiled() -> TrainingState:
            state = make()
            return {**state, self._name: spoil(state[self._name])}

        self._inner.checkpoint(steps, spoiled)

    def restored(self) -> TrainingState | None:
        return self._inner.restored()


def spoil(value: Any) -> Any:
    """Another number, another generator, or one other row."""
    if isinstance(value, Ring):
        columns = {name: array.copy() for name, array in value.columns.items()}
        for array in columns.values():
            array[(value.written - 1) % len(array)] += 1
        return Ring(columns, value.written)
    if value.dtype == bool:
        return ~value
    if value.dtype == np.uint8 and value[:1].tobytes() == b"{":  # a generator in JSON
        return np.frombuffer(value.tobytes().replace(b'"inc": ', b'"inc": 2'), np.uint8)
    spoiled = value.copy()
    middle = spoiled.size // 2
    spoiled.reshape(-1)[middle : middle + 20] += np.ones((), value.dtype)
    return spoiled


class Spoiled:
    """An algorithm whose checkpoints lack one thing."""

    def __init__(self, algorithm: Any, name: str) -> None:
        self._algorithm, self._name = algorithm, name
        self.num_envs, self.action_spaces = algorithm.num_envs, algorithm.action_spaces
        self.needs_goals = needs_goals(algorithm)

    def train(self, env: ReachVectorEnv, steps: int, seed: int, progress: Progress) -> Policy:
        policy: Policy = self._algorithm.train(env, steps, seed, Spoiling(progress, self._name))
        return policy


@pytest.mark.parametrize(("algorithm", "name"), CASES)
def test_whatever_a_checkpoint_lacks_is_found(algorithm: str, name: str):
    """A weight, a moment, a generator, a counter, an observation, one row of the replay buffer."""
    built: Any = REGISTRY.get("algorithms", algorithm).load()(**SETTINGS[algorithm])
    with pytest.raises(AssertionError, match="something is not in the checkpoint"):
        a_training_goes_on_where_it_stood(Spoiled(built, name))


@pytest.mark.parametrize("check", [checkpoints_change_nothing, a_training_goes_on_where_it_stood])
@pytest.mark.parametrize(
    "algorithm", [pytest.param(name, marks=[pytest.mark.slow] * (name in BY_SB3[1:])) for name in SETTINGS]
)
def test_nothing_is_found_where_nothing_is_lacking(algorithm: str, check: Callable[..., None]):
    """With the same settings."""
    check(REGISTRY.get("algorithms", algorithm).load()(**SETTINGS[algorithm]))
