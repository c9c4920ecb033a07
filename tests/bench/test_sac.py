"""What the harness costs on top of stable-baselines3."""

import gymnasium
import numpy as np
import pytest
import torch
from stable_baselines3 import SAC
from stable_baselines3.common.monitor import Monitor

import harness
from harness.trace import TraceWriter
from harness_plugins.algorithms.sac import Sac

pytestmark = pytest.mark.bench
STEPS = 600


def test_sac_has_ninety_five_hundredths_of_bare_sac(tmp_path, speed_ratio):
    """SAC through the harness, trace on, does at least 0.95 of the steps of bare stable-baselines3 on the same env."""
    torch.set_num_threads(1)
    settings = Sac()

    def bare() -> None:
        model = SAC(
            "MlpPolicy",
            Monitor(gymnasium.make("harness/Reach-v0")),
            learning_rate=settings.learning_rate,
            gamma=settings.gamma,
            batch_size=settings.batch_size,
            buffer_size=STEPS,
            learning_starts=settings.learning_starts,
            ent_coef=settings.ent_coef,
            policy_kwargs={"net_arch": list(settings.net_arch)},
            seed=0,
            device="cpu",
        )
        model.learn(STEPS)

    def through_the_harness() -> None:
        env = harness.make_env()
        with TraceWriter(tmp_path / "trace.parquet", env.robot.dof, env.robot.dof) as recorder:
            env.recorder = recorder
            env.reset(seed=0)
            policy = settings.train(env, STEPS, 0, lambda steps: None)
        assert np.isfinite(policy.weights["mean.weight"]).all()

    assert speed_ratio(bare, through_the_harness, rounds=5) >= 0.95
