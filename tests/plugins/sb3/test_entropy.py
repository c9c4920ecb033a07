"""How random a soft actor acts."""

from types import SimpleNamespace

import numpy as np
import pytest
import stable_baselines3
import torch

from harness.env.vector_env import ReachVectorEnv
from harness.task import ReachTask
from harness_plugins.kit import IdealSimulator
from harness_plugins.kit.trainings import NegativeDistance
from harness_plugins.sb3 import VecEnvAdapter
from harness_plugins.sb3.callback import actor_entropy
from tests.registered import FD100


@pytest.fixture(scope="module")
def model():
    """A soft actor-critic that has seen 40 steps of two envs."""
    env = ReachVectorEnv(IdealSimulator(), FD100, ReachTask(), NegativeDistance(), 2)
    env.reset(seed=0)
    return stable_baselines3.SAC("MlpPolicy", VecEnvAdapter(env), seed=0, device="cpu", buffer_size=1000).learn(40)


def test_entropy_falls_with_the_spread(model):
    """An actor whose standard deviation is e times smaller has one nat less per action, while it saturates nothing."""
    bias, weight = model.actor.log_std.bias, model.actor.log_std.weight
    found = []
    with torch.no_grad():
        model.actor.mu.weight.zero_(), model.actor.mu.bias.zero_(), weight.zero_()
        for log_std in (-3.0, -4.0):
            bias.fill_(log_std)
            torch.manual_seed(0)
            found.append(actor_entropy(model))
    assert found[0] - found[1] == pytest.approx(len(bias), rel=0.02)
    assert found[1] == pytest.approx(len(bias) * (-4.0 + 0.5 * np.log(2.0 * np.pi * np.e)), abs=0.5)


def test_training_takes_no_notice(model):
    """Its random numbers stay where they are."""
    before = torch.random.get_rng_state()
    actor_entropy(model)
    assert torch.equal(torch.random.get_rng_state(), before)


def test_other_models_have_none():
    """No actor, one that draws nothing, or nothing seen yet."""
    seen = SimpleNamespace(pos=3)
    soft = SimpleNamespace(action_log_prob=None)
    assert actor_entropy(SimpleNamespace()) is None
    assert actor_entropy(SimpleNamespace(actor=SimpleNamespace(), replay_buffer=seen)) is None
    assert actor_entropy(SimpleNamespace(actor=soft, replay_buffer=SimpleNamespace(pos=0))) is None
