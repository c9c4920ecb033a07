"""Updates: those of stable-baselines3, number by number, given the same weights, transitions and noise."""

from typing import Any

import gymnasium
import numpy as np
import pytest
import stable_baselines3
import torch
from numpy.random import default_rng
from numpy.testing import assert_allclose
from stable_baselines3.common.logger import configure
from stable_baselines3.common.type_aliases import ReplayBufferSamples
from torch.distributions import normal

from harness import Float32
from harness_plugins.algorithms.sac_fast import SacFast
from harness_plugins.fast_sac.training import Learner, Replay

OBSERVATION, ACTION, ROWS = 5, 3, 32


class Still(gymnasium.Env[Any, Any]):
    """An env with spaces and nothing else."""

    observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (OBSERVATION,), np.float32)
    action_space = gymnasium.spaces.Box(-1.0, 1.0, (ACTION,), np.float32)


class SameNoise:
    """Gives the learner and the library the same normal numbers: for each update those of both batches."""

    def __init__(self) -> None:
        self.given: list[Float32] = []
        self.rng = default_rng(3)

    def standard_normal(self, shape, dtype):
        """What the learner asks for."""
        noise = self.rng.standard_normal(shape, dtype=dtype)
        self.given += list(noise)
        return noise

    def uniform(self, *args):
        """First weights."""
        return self.rng.uniform(*args)

    def standard_normal_of_torch(self, shape, dtype, device):
        """What the library asks for afterwards."""
        noise = self.given.pop(0)
        assert tuple(shape) == noise.shape
        return torch.tensor(noise)


def transitions(rng):
    """A hundred of them, some terminated."""
    replay, ended = Replay(100, OBSERVATION, ACTION), rng.random(100) < 0.3
    observation, following = rng.standard_normal((2, 100, OBSERVATION), dtype=np.float32)
    actions = rng.uniform(-1.0, 1.0, (100, ACTION)).astype(np.float32)
    replay.add(observation, actions, following, rng.standard_normal(100), ended)
    return replay


def samples(batch):
    """As the library takes them."""
    before, after = (torch.tensor(inputs.copy()) for inputs in batch.inputs)
    ended, reward = (torch.tensor(column.copy())[:, None] for column in (1.0 - batch.goes_on, batch.reward))
    return ReplayBufferSamples(
        before[:, ACTION:-1], before[:, :ACTION], after[:, ACTION:-1], ended, reward  # type: ignore[arg-type]
    )  # fmt: skip


def give(found):
    """A buffer's method that draws no others."""
    return lambda *_, **__: found


def put(networks, modules):
    """Give the library's linear layers the weights of the first network, those of the second network, ..."""
    layers = [layer for module in modules for layer in module.modules() if isinstance(layer, torch.nn.Linear)]
    flat = [(weight[k, :-1].T, weight[k, -1]) for k in range(len(networks[0])) for weight in networks]
    assert len(layers) == len(flat)
    with torch.no_grad():
        for layer, (weight, bias) in zip(layers, flat, strict=True):
            layer.weight.copy_(torch.tensor(weight.copy()))
            layer.bias.copy_(torch.tensor(bias.copy()))


def require_equal(networks, modules):
    """The weights of the library's layers, in the same order."""
    layers = [layer for module in modules for layer in module.modules() if isinstance(layer, torch.nn.Linear)]
    flat = [(weight[k, :-1].T, weight[k, -1]) for k in range(len(networks[0])) for weight in networks]
    for layer, (weight, bias) in zip(layers, flat, strict=True):
        assert_allclose(weight, layer.weight.detach().numpy(), rtol=1e-3, atol=2e-4)
        assert_allclose(bias, layer.bias.detach().numpy(), rtol=1e-3, atol=2e-4)


def split_heads(actor):
    """Hidden layers, and the last one as the library has it: a layer for means, one for deviations."""
    *hidden, last = actor
    return tuple(hidden), (last[..., :ACTION],), (last[..., ACTION:],)


def of_observation_first(critics):
    """The library's critics take the observation before the action."""
    first, *rest = critics
    rows = [*range(ACTION, ACTION + OBSERVATION), *range(ACTION), ACTION + OBSERVATION]
    return first[:, rows], *rest


def put_actor(networks, actor):
    """The same for the actor."""
    for part, module in zip(split_heads(networks), (actor.latent_pi, actor.mu, actor.log_std), strict=True):
        put(part, [module])


def beside(settings, monkeypatch):
    """A learner and a model of the library with the same weights and the same noise to come."""
    noise = SameNoise()
    learner = Learner(settings, OBSERVATION, ACTION, noise)
    model = stable_baselines3.SAC(
        "MlpPolicy", Still(), learning_rate=settings.learning_rate, gamma=settings.gamma, tau=settings.tau,
        batch_size=ROWS, buffer_size=10, ent_coef=settings.ent_coef if settings.learns_coefficient else 0.2,
        policy_kwargs={
            "net_arch": list(settings.net_arch),
            "activation_fn": {"relu": torch.nn.ReLU, "tanh": torch.nn.Tanh}[settings.activation],
        },
    )  # fmt: skip
    put_actor(learner.actor, model.actor)
    for critic in (model.critic, model.critic_target):
        put(of_observation_first(learner._critics.networks), list(critic.q_networks))
    monkeypatch.setattr(normal, "_standard_normal", noise.standard_normal_of_torch)
    return learner, model, noise


CASES = [
    {},
    {"activation": "tanh", "net_arch": (16,)},
    {"ent_coef": "0.2", "tau": 0.5},
    {"ent_coef": "auto", "gamma": 0.5, "learning_rate": 1e-2},
]


@pytest.mark.parametrize("given", CASES)
def test_updates_are_those_of_the_library(given, monkeypatch):
    """After 20 of them actor, critics, targets, entropy coefficient and losses are the same, to rounding."""
    settings = SacFast(**{"net_arch": (16, 24), "batch_size": ROWS, **given})
    learner, model, _ = beside(settings, monkeypatch)
    rng = default_rng(0)
    replay = transitions(rng)
    model.set_logger(configure(None, []))
    for _ in range(20):
        batch = replay.draw(ROWS, rng)
        monkeypatch.setattr(model.replay_buffer, "sample", give(samples(batch)))
        losses = learner.update(batch)
        model.train(1, ROWS)
        told = model.logger.name_to_value
        assert_allclose(losses.value, told["train/critic_loss"], rtol=1e-3)
        assert_allclose(losses.policy, told["train/actor_loss"], rtol=1e-3, atol=1e-4)
        told.clear()
    for part, module in zip(
        split_heads(learner.actor), (model.actor.latent_pi, model.actor.mu, model.actor.log_std), strict=True
    ):
        require_equal(part, [module])
    require_equal(of_observation_first(learner._critics.networks), list(model.critic.q_networks))
    require_equal(of_observation_first(learner._targets), list(model.critic_target.q_networks))
    if settings.learns_coefficient:
        assert_allclose(learner.coefficient, model.log_ent_coef.exp().item(), rtol=1e-4)
    else:
        assert learner.coefficient == pytest.approx(0.2)


def test_a_terminated_transition_is_worth_its_reward():
    """Nothing that follows counts: with gamma 1 the critics go to the reward alone."""
    rng = default_rng(0)
    settings = SacFast(net_arch=(16,), batch_size=ROWS, gamma=1.0, ent_coef="0.5", learning_rate=1e-2)
    learner, replay = Learner(settings, OBSERVATION, ACTION, rng), Replay(1, OBSERVATION, ACTION)
    ones = np.ones((1, OBSERVATION), np.float32)
    replay.add(ones, ones[:, :ACTION], ones, np.array([3.0]), np.array([True]))
    for _ in range(300):
        losses = learner.update(replay.draw(ROWS, rng))
    assert losses.value < 1e-3


def test_entropy_is_aimed_at_minus_the_number_of_actions():
    """The coefficient rises below that, and falls above it."""
    for log_std, direction in ((-4.0, 1.0), (0.0, -1.0)):
        rng = default_rng(0)
        learner = Learner(SacFast(net_arch=(8,), batch_size=ROWS), OBSERVATION, ACTION, rng)
        learner.actor[-1][0, -1, ACTION:] = log_std
        before = learner.coefficient
        assert (learner.update(transitions(rng).draw(ROWS, rng)).entropy < -ACTION) == (direction > 0)
        assert (learner.coefficient - before) * direction > 0
