"""Goals, as the library's replay buffer and networks see them."""

from typing import Any

import numpy as np
import pytest
from stable_baselines3 import HerReplayBuffer

from harness.algorithm import Goals
from harness.testing.trainings import WatchedEnv
from harness_plugins.sb3.hindsight import GoalEnvAdapter, HindsightSAC
from harness_plugins.sb3.policies import squashed_gaussian


@pytest.fixture(scope="module")
def model() -> Any:
    """A model that has gathered 60 steps in two envs."""
    env = WatchedEnv(2, with_goals=True)
    env.reset(seed=0)
    settings: Any = {"replay_buffer_class": HerReplayBuffer, "policy_kwargs": {"net_arch": [8]}, "buffer_size": 200}
    return HindsightSAC("MultiInputPolicy", GoalEnvAdapter(env), seed=0, device="cpu", **settings).learn(60)


def test_the_policy_sees_what_the_network_sees(model: Any):
    """A row as the env shows it, for the parts of a dict: columns are not mixed up."""
    seen = np.random.default_rng(0).uniform(-1.0, 1.0, (5, 28)).astype(np.float32)
    own, _ = model.predict(model.env._seen(seen), deterministic=True)
    np.testing.assert_allclose(squashed_gaussian(model, "relu", "her").act(seen), own, atol=1e-6)


def test_steps_are_paid_again_by_the_reward_of_the_training(model: Any):
    """Each step of a batch has the goal that it is paid for, most of them another one than they had."""
    batch = model.replay_buffer.sample(50)
    goals: Goals = model.env.env.goals
    seen = {name: part.numpy() for name, part in batch.next_observations.items()}
    in_hindsight = slice(50 - 40, None)  # the last four fifths
    again = goals.pay(seen["achieved_goal"].astype(float), seen["desired_goal"].astype(float))
    np.testing.assert_allclose(batch.rewards.numpy()[in_hindsight, 0], again[in_hindsight], rtol=1e-5, atol=1e-6)
    targets = np.unique(seen["desired_goal"][:10], axis=0)
    assert len(targets) == 1
    assert len(np.unique(seen["desired_goal"][in_hindsight], axis=0)) > 5


def test_parts_are_in_the_order_of_the_columns(model: Any):
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
    settings: Any = {"replay_buffer_class": HerReplayBuffer, "buffer_size": 99, "policy_kwargs": {"net_arch": [8]}}
    model = HindsightSAC("MultiInputPolicy", GoalEnvAdapter(env), learning_starts=2, seed=0, device="cpu", **settings)
    assert model.learn(15)._n_updates == 0
