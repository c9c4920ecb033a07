"""A built-in algorithm that leaves anything out of its checkpoints is found by the checks."""

import numpy as np
import pytest

from harness.algorithm import Progress, Ring, needs_goals
from harness_plugins.kit.kits import KITS
from tests.registered import REGISTRY

CHECKS = {check.name: check for check in KITS["algorithms"].contract}
SMALL = {"net_arch": (8,), "batch_size": 16}
SELDOM = {**SMALL, "learning_starts": 50, "train_freq": 5}
SETTINGS = {
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
    "sac-fast": """rng observation rounds decisions replay learner.targets learner.actor.parameters learner.actor.first
        learner.critics.second learner.critics.steps learner.coefficient.first learner.coefficient.value""",
    "spg": "rng observation updates policy.log_std policy.adam.0.exp_avg baseline.adam.1.exp_avg_sq",
    "ppo": "model.policy.optimizer.0.exp_avg model._last_obs done",
    "dqn": "model._n_calls model.exploration_rate model.policy.q_net_target.q_net.0.weight model.actions",
    "td3": "model._n_updates model.policy.actor_target.mu.0.weight model.numpy.rest done",
    "sb3-sac": """model.torch model.replay model.actor.optimizer.0.exp_avg model.numpy.keys model._last_obs
        model.num_timesteps model.policy.actor.mu.weight model.policy.critic_target.qf0.0.bias
        model.critic.optimizer.1.exp_avg_sq model.ent_coef_optimizer.0.exp_avg model.variable.log_ent_coef""",
    "her": "model.replay model.episodes.ep_length model.episodes._current_ep_start model._last_obs.columns_0",
}
"""Of what each keeps, one of every sort."""
QUICK = ("sac-fast", "spg")
"""Of the others, by stable-baselines3, one thing of each shows in every run that the check sees through the library."""


class Spoiling(Progress):
    """Hands on checkpoints with one thing spoiled."""

    def __init__(self, inner, name):
        self._inner, self._name = inner, name

    def checkpoint(self, steps, make):
        self._inner.checkpoint(steps, lambda: {**(state := make()), self._name: spoil(state[self._name])})

    def restored(self):
        return self._inner.restored()


def spoil(value):
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

    def __init__(self, algorithm, name):
        self._algorithm, self._name = algorithm, name
        self.num_envs, self.action_spaces = algorithm.num_envs, algorithm.action_spaces
        self.needs_goals = needs_goals(algorithm)

    def train(self, env, steps, seed, progress):
        return self._algorithm.train(env, steps, seed, Spoiling(progress, self._name))


def slow(is_slow, *case):
    """A case of a parametrized test."""
    return pytest.param(*case, marks=[pytest.mark.slow] * is_slow)


def build(algorithm):
    """With its small settings."""
    return REGISTRY.get("algorithms", algorithm).load()(**SETTINGS[algorithm])


@pytest.mark.parametrize(
    ("algorithm", "name"),
    [
        slow(algorithm not in QUICK and index > 0, algorithm, name)
        for algorithm, names in NEEDED.items()
        for index, name in enumerate(names.split())
    ],
)
def test_whatever_a_checkpoint_lacks_is_found(algorithm, name):
    """A weight, a moment, a generator, a counter, an observation, one row of the replay buffer."""
    with pytest.raises(AssertionError, match="something is not in the checkpoint"):
        CHECKS["algo-resume"](Spoiled(build(algorithm), name))


@pytest.mark.parametrize("check", ["algo-checkpoint-silent", "algo-resume"])
@pytest.mark.parametrize("algorithm", [slow(name not in (*QUICK, "ppo"), name) for name in SETTINGS])
def test_nothing_is_found_where_nothing_is_lacking(algorithm, check):
    """With the same settings."""
    CHECKS[check](build(algorithm))
