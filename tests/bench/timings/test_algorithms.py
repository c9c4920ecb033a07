"""What the harness costs on top of stable-baselines3, algorithm by algorithm, on the same physics and settings."""

from typing import Any

import gymnasium
import numpy as np
import pytest
import stable_baselines3
import torch
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.noise import NormalActionNoise

import harness
from harness.progress import Progress
from harness.record.trace import TraceWriter
from harness_plugins.algorithms.dqn import Dqn
from harness_plugins.algorithms.ppo import Ppo
from harness_plugins.algorithms.sac import Sac
from harness_plugins.algorithms.td3 import Td3

pytestmark = pytest.mark.bench
SHARED = ("learning_rate", "gamma", "batch_size")
OFF_POLICY = (*SHARED, "learning_starts", "train_freq", "gradient_steps", "tau")
DISCRETE = "fd100-reach:action=discrete"
CASES: dict[str, tuple[Any, str, int, tuple[str, ...], dict[str, Any]]] = {
    "sac": (Sac(), "fd100-reach", 600, OFF_POLICY, {"ent_coef": Sac().ent_coef}),
    "td3": (
        Td3(), "fd100-reach", 800, OFF_POLICY,
        {
            "action_noise": NormalActionNoise(np.zeros(6), np.full(6, Td3().action_noise)),
            "policy_delay": Td3().policy_delay,
        },
    ),
    "ppo": (
        Ppo(), "fd100-reach", 20 * Ppo().rollout, (*SHARED, "gae_lambda"),
        {"n_steps": Ppo().rollout, "n_epochs": Ppo().epochs},
    ),
    "dqn": (
        Dqn(), DISCRETE, 1000, OFF_POLICY,
        {
            "target_update_interval": Dqn().target_update_interval,
            "exploration_fraction": Dqn().exploration_fraction,
            "exploration_final_eps": Dqn().exploration_end,
        },
    ),
}  # fmt: skip
"""Algorithm, task, steps, the settings that the library calls by the same name, and the others."""


@pytest.mark.parametrize("name", CASES)
def test_algorithm_has_ninety_five_hundredths_of_the_bare_one(tmp_path, speed_ratio, name: str):
    """Through the harness, trace on, it does at least 0.95 of the steps of bare stable-baselines3 on the same env."""
    torch.set_num_threads(1)
    settings, task, steps, same, others = CASES[name]
    buffer = {} if name == "ppo" else {"buffer_size": steps}

    def bare() -> int:
        model = getattr(stable_baselines3, name.upper())(
            "MlpPolicy",
            Monitor(gymnasium.make("harness/Reach-v0", task=task)),
            policy_kwargs={
                "net_arch": list(settings.net_arch),
                "activation_fn": {"relu": torch.nn.ReLU, "tanh": torch.nn.Tanh}[settings.activation],
            },
            seed=0,
            device="cpu",
            **{key: getattr(settings, key) for key in same},
            **others,
            **buffer,
        )
        model.learn(steps)
        return int(model._n_updates)

    def through_the_harness() -> None:
        env = harness.make_env(task=task)
        with TraceWriter(tmp_path / "trace.parquet", env.robot.dof, env.episodes.action.shape[1]) as recorder:
            env.recorder = recorder
            env.reset(seed=0)
            settings.train(env, steps, 0, Progress())
        assert env.environment_steps == steps

    assert bare() > 0
    assert speed_ratio(bare, through_the_harness, rounds=5) >= 0.95
