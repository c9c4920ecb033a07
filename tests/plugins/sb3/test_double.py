"""Double deep Q-learning: the target, against numbers found by hand.

Three choices; both networks are linear without a bias, so that Q(s, a) of the one-hot state s = i is weight[a, i].
"""

import gymnasium
import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose, assert_array_equal
from stable_baselines3 import DQN
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.vec_env import DummyVecEnv

from harness_plugins.sb3.double import DoubleDQN

GAMMA = 0.5
ONLINE = [[0.0, 1.0], [0.0, 5.0], [0.0, 2.0]]
"""Q(s, a): of state 1, choice 1 is the best."""
TARGET = [[0.0, 7.0], [0.0, 3.0], [0.0, 4.0]]
"""Q_target(s, a): of state 1, choice 0 is the best, and choice 1 is worth 3."""
REWARD = 10.0


class Line(gymnasium.Env[np.ndarray, int]):
    """Spaces for the model; nothing is done in it."""

    observation_space = gymnasium.spaces.Box(0.0, 1.0, (2,), np.float32)
    action_space = gymnasium.spaces.Discrete(3)

    def reset(self, *, seed=None, options=None):
        """Nowhere."""
        return np.zeros(2, np.float32), {}


def make(library):
    """A model with the two networks, which does not move them."""
    model = library(
        "MlpPolicy", DummyVecEnv([Line]), gamma=GAMMA, learning_rate=0.0, buffer_size=1, seed=0, device="cpu",
        policy_kwargs={"net_arch": []},
    )  # fmt: skip
    for network, values in ((model.policy.q_net, ONLINE), (model.policy.q_net_target, TARGET)):
        (layer,) = network.q_net
        layer.weight.data, layer.bias.data = torch.tensor(values), torch.zeros(3)
    model.set_logger(Logger(None, []))
    return model


def loss_of(library, terminated=False, truncated=False):
    """The loss of one transition from state 0 by choice 2, worth 0, to state 1."""
    model = make(library)
    seen, after = np.eye(2, dtype=np.float32)[:, None]
    infos = [{"TimeLimit.truncated": truncated}]
    done = np.array([terminated or truncated])
    model.replay_buffer.add(seen, after, np.array([[2]]), np.array([REWARD]), done, infos)
    model.train(gradient_steps=1, batch_size=4)
    return float(model.logger.name_to_value["train/loss"])


def huber(target):
    """The loss of an error of more than 1, from a value of 0."""
    return target - 0.5


def test_target_is_the_target_networks_value_of_the_online_networks_choice():
    """It is r + gamma Q_target(s', argmax_a Q(s', a)): choice 1 is taken, and worth 3."""
    assert loss_of(DoubleDQN) == pytest.approx(huber(REWARD + GAMMA * 3.0))


def test_the_librarys_own_target_is_another():
    """It is r + gamma max_a Q_target(s', a): the largest is 7."""
    assert loss_of(DQN) == pytest.approx(huber(REWARD + GAMMA * 7.0))


def test_terminal_state_is_worth_nothing():
    """Where the episode is terminated the target is the reward."""
    assert loss_of(DoubleDQN, terminated=True) == pytest.approx(huber(REWARD))


def test_truncated_episode_would_have_gone_on():
    """At the horizon the target is that of a step within an episode."""
    assert loss_of(DoubleDQN, truncated=True) == pytest.approx(huber(REWARD + GAMMA * 3.0))


def test_target_of_a_batch_is_each_states_own():
    """Four states, each with another choice and another value."""
    model = make(DoubleDQN)
    states = torch.tensor([[0.0, 1.0], [1.0, 0.0], [0.0, -1.0], [0.0, 2.0]])
    # In state (0, -1) the values of the online network change their signs: choice 0 is the best, of value -7.
    assert_array_equal(model.q_net_target(states).numpy(force=True), [[3.0], [0.0], [-7.0], [6.0]])


def test_target_network_follows_the_online_network():
    """Polyak averaging moves the target network's own weights, and leaves the online network as it is."""
    model = make(DoubleDQN)
    model.tau, model.target_update_interval = 0.25, 1
    model._on_step()
    (online,), (target,) = model.policy.q_net.q_net, model.policy.q_net_target.q_net
    assert_allclose(target.weight.detach(), 0.75 * np.array(TARGET) + 0.25 * np.array(ONLINE))
    assert_array_equal(online.weight.detach(), ONLINE)


def test_only_the_online_network_is_optimised():
    """The wrapped target brings no parameters of its own."""
    model = make(DoubleDQN)
    assert [id(p) for p in model.q_net_target.parameters()] == [id(p) for p in model.policy.q_net_target.parameters()]
