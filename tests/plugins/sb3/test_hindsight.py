"""Goals, as the library's replay buffer and networks see them."""

from typing import Any

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.spaces import Box, Dict
from numpy.random import default_rng
from numpy.testing import assert_allclose
from stable_baselines3 import SAC, HerReplayBuffer

from harness import RecordRewards
from harness.algorithm import Progress
from harness.experiment.environments.world import EnvironmentBatch
from harness_plugins.algorithms.her import Her
from harness_plugins.kit.trainings import WatchedEnv
from harness_plugins.sb3 import policy_from
from harness_plugins.sb3.hindsight import GoalEnvAdapter, HindsightSAC


class _Line(gymnasium.Env[Any, Any]):
    """A point has to come to another one within nine steps; every reset but the first is one without a seed."""

    def __init__(self) -> None:
        box = Box(-9.0, 9.0, (1,), np.float32)
        self.observation_space = Dict({"achieved_goal": box, "desired_goal": box, "observation": box})
        self.action_space = Box(-1.0, 1.0, (1,), np.float32)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.at, self.moved, self.steps = np.zeros(1, np.float32), np.zeros(1, np.float32), 0
        self.goal = self.np_random.uniform(-1.0, 1.0, 1).astype(np.float32)
        return self._observed(), {}

    def step(self, action):
        self.moved = 0.3 * action
        self.at, self.steps = self.at + self.moved, self.steps + 1
        paid = self.compute_reward(self.at[np.newaxis], self.goal[np.newaxis], [{}])
        return self._observed(), float(paid[0]), False, self.steps == 9, {}

    def compute_reward(self, achieved, desired, infos):
        return -(np.abs(achieved - desired)[:, 0] > 0.2).astype(np.float32)

    def _observed(self):
        return {"achieved_goal": self.at, "desired_goal": self.goal, "observation": self.moved}


class _SeededOnce(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Begins as the harness begins: an episode with a seed, which nobody plays, and one without."""

    def reset(self, *, seed=None, options=None):
        if seed is not None:
            self.env.reset(seed=7)
        return self.env.reset()


@pytest.fixture(scope="module")
def model():
    """A model that has gathered 60 steps in two envs."""
    env = WatchedEnv(2, with_goals=True)
    env.reset(seed=0)
    settings = {"replay_buffer_class": HerReplayBuffer, "policy_kwargs": {"net_arch": [8]}, "buffer_size": 200}
    return HindsightSAC("MultiInputPolicy", GoalEnvAdapter(env), seed=0, device="cpu", **settings).learn(60)


def test_the_policy_sees_what_the_network_sees(model):
    """A row as the env shows it, for the parts of a dict: columns are not mixed up."""
    seen = default_rng(0).uniform(-1.0, 1.0, (5, 28)).astype(np.float32)
    own, _ = model.predict(model.env._seen(seen), deterministic=True)
    assert_allclose(policy_from(model, "relu", "her").act(seen), own, atol=1e-6)


def test_steps_are_paid_again_by_the_reward_of_the_training(model):
    """Each step of a batch has the goal that it is paid for, most of them another one than they had."""
    batch = model.replay_buffer.sample(50)
    goals = model.env.env.goals
    seen = {name: part.numpy() for name, part in batch.next_observations.items()}
    in_hindsight = slice(50 - 40, None)  # the last four fifths
    again = goals.pay(seen["achieved_goal"].astype(float), seen["desired_goal"].astype(float))
    assert_allclose(batch.rewards.numpy()[in_hindsight, 0], again[in_hindsight], rtol=1e-5, atol=1e-6)
    assert len(np.unique(seen["desired_goal"][:10], axis=0)) == 1
    assert len(np.unique(seen["desired_goal"][in_hindsight], axis=0)) > 5


def test_parts_are_in_the_order_of_the_columns(model):
    """What is neither goal stands between them, under a name of its own."""
    parts = model.env.observation_space.spaces
    assert [(name, *box.shape) for name, box in parts.items()] == [
        ("columns_0", 18),
        ("desired_goal", 3),
        ("achieved_goal", 3),
        ("columns_24", 4),
    ]


def test_nothing_is_learned_before_an_episode_ends():
    """What follows on a step is its goal: of an episode under way it is not known."""
    env = WatchedEnv(1, with_goals=True)
    env.reset(seed=0)
    settings = {"replay_buffer_class": HerReplayBuffer, "buffer_size": 99, "policy_kwargs": {"net_arch": [8]}}
    model = HindsightSAC("MultiInputPolicy", GoalEnvAdapter(env), learning_starts=2, seed=0, device="cpu", **settings)
    assert model.learn(15)._n_updates == 0


def test_it_learns_what_the_library_learns_by_itself(tmp_path):
    """In the same env, with the same settings and seed: the same network in the end."""
    settings = {"learning_starts": 30, "batch_size": 16, "gamma": 0.9, "learning_rate": 1e-3}
    env = _Line()
    recorded = RecordRewards(env, tmp_path, trained_with="own", rewards={"own": "own"}, pay=True)
    batch = EnvironmentBatch([recorded], lambda achieved, desired: env.compute_reward(achieved, desired, []))
    batch.reset(seed=7)
    policy = Her(net_arch=(8,), ent_coef="0.1", **settings).train(batch, 200, 3, Progress())
    batch.close()
    library = SAC(
        "MultiInputPolicy", _SeededOnce(_Line()), seed=3, device="cpu", ent_coef=0.1, buffer_size=200,
        replay_buffer_class=HerReplayBuffer, policy_kwargs={"net_arch": [8], "activation_fn": torch.nn.ReLU},
        **settings,
    ).learn(200)  # fmt: skip
    expected = policy_from(library, "relu", "library").weights
    assert policy.weights.keys() == expected.keys()
    assert all(np.array_equal(policy.weights[name], expected[name]) for name in expected)
