"""What the harness costs on top of stable-baselines3, algorithm by algorithm, on the same physics and settings."""

from typing import Any

import numpy as np
import pytest
from stable_baselines3.common.noise import NormalActionNoise

import harness
from harness.progress import Progress
from harness.record.trace import TraceWriter
from harness_plugins.algorithms.dqn import Dqn
from harness_plugins.algorithms.ppo import Ppo
from harness_plugins.algorithms.sac import Sac
from harness_plugins.algorithms.td3 import Td3

pytestmark = pytest.mark.bench
DISCRETE = "fd100-reach:action=discrete"
ENOUGH = 128
"""Steps with which each of them learns at least once."""
CASES: dict[str, tuple[Any, str, int, dict[str, Any]]] = {
    "sac": (Sac(), "fd100-reach", 600, {"ent_coef": Sac().ent_coef}),
    "td3": (
        Td3(), "fd100-reach", 800,
        {
            "action_noise": NormalActionNoise(np.zeros(6), np.full(6, Td3().action_noise)),
            "policy_delay": Td3().policy_delay,
        },
    ),
    "ppo": (
        Ppo(), "fd100-reach", 20 * Ppo().rollout,
        {"gae_lambda": Ppo().gae_lambda, "n_steps": Ppo().rollout, "n_epochs": Ppo().epochs},
    ),
    "dqn": (
        Dqn(), DISCRETE, 1000,
        {
            "target_update_interval": Dqn().target_update_interval,
            "exploration_fraction": Dqn().exploration_fraction,
            "exploration_final_eps": Dqn().exploration_end,
        },
    ),
}  # fmt: skip
"""Algorithm, task, steps, and the settings that the library calls by other names or that it alone has."""


@pytest.mark.parametrize("name", CASES)
def test_algorithm_has_ninety_five_hundredths_of_the_bare_one(
    tmp_path, require_speed, train_bare, amount, name: str
):  # fmt: skip
    """Through the harness, trace on, it does at least 0.95 of the steps of bare stable-baselines3 on the same env."""
    settings, task, full, others = CASES[name]
    steps = amount(full, ENOUGH)

    def bare() -> None:
        assert train_bare(name, settings, steps, task, **others) > 0

    def through_the_harness() -> None:
        env = harness.make_env(task=task)
        with TraceWriter(tmp_path / "trace.parquet", env.robot.dof, env.episodes.action.shape[1]) as recorder:
            env.recorder = recorder
            env.reset(seed=0)
            settings.train(env, steps, 0, Progress())
        assert env.environment_steps == steps

    require_speed(bare, through_the_harness, at_least=0.95, rounds=5)
