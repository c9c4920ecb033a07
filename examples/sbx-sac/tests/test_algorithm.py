"""The algorithm keeps its contract, and its policy acts as sbx's does."""

import numpy as np
import pytest

from harness import make_env
from harness.algorithm import Progress
from harness_plugins.kit import check_contract

pytest.importorskip("sbx", reason="sbx is not installed: pip install sbx-rl")

from sbx import SAC
from sbx_sac.algorithm import SbxSac

from harness_plugins.sb3 import VecEnvAdapter


def test_contract() -> None:
    """It learns an easy task, keeps its budget, and repeats itself by its seed; some minutes."""
    check_contract("algorithm", SbxSac())


def test_policy_is_the_librarys() -> None:
    """Without noise, what numpy computes from the weights is what sbx predicts."""
    env = make_env("kinematic", num_envs=2)
    seen, _ = env.reset(seed=0)
    model = SAC("MlpPolicy", VecEnvAdapter(env), policy_kwargs={"net_arch": [64, 64]}, seed=0)
    expected, _ = model.predict(seen, deterministic=True)
    np.testing.assert_allclose(SbxSac()._policy(model).act(seen), expected, atol=1e-5)


def test_train_takes_any_env() -> None:
    """Of the harness: here two arms side by side."""
    env = make_env("kinematic", num_envs=2)
    env.reset(seed=0)
    policy = SbxSac(num_envs=2).train(env, 240, 0, Progress())
    assert env.environment_steps == 240
    assert policy.act(env.reset()[0]).shape == (2, 6)
