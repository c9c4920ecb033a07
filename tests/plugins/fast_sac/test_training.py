"""A training: how often it learns, what it remembers, and what it tells."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import stable_baselines3
from numpy.testing import assert_allclose, assert_array_equal

from harness.algorithm import Progress
from harness.env.vector_env import ReachVectorEnv
from harness.policy import Policy
from harness_plugins.algorithms.sac import Sac
from harness_plugins.algorithms.sac_fast import SacFast
from harness_plugins.fast_sac import training
from harness_plugins.fast_sac.training import Batch, Learner, Replay
from harness_plugins.kit import IdealSimulator
from harness_plugins.kit.trainings import EASY, ENV_SEED, NegativeDistance, WatchedEnv, easy_robot

SMALL = {"net_arch": (8,), "batch_size": 16}


class Told(Progress):
    """Keeps what it is told."""

    def __init__(self) -> None:
        self.steps: list[int] = []
        self.policies: list[tuple[int, Policy]] = []
        self.told: list[tuple[int, Mapping[str, float]]] = []

    def __call__(self, steps):
        self.steps.append(steps)

    def policy(self, steps, make):
        self.policies.append((steps, make()))

    def scalars(self, steps, values):
        self.told.append((steps, values))


def train(settings, steps, told=None):
    """On the easy task; returns the env."""
    env = WatchedEnv(settings.num_envs)
    env.reset(seed=ENV_SEED)
    settings.train(env, steps, 0, told or Told())
    return env


@pytest.fixture
def updates(monkeypatch):
    """The batch of each update that is made."""
    made = []

    class Watched(Learner):
        def update(self, batch):
            made.append(Batch(*(np.array(part) for part in batch)))
            return super().update(batch)

    monkeypatch.setattr(training, "Learner", Watched)
    return made


@pytest.mark.parametrize(
    ("given", "count"),
    [
        ({}, 100),
        ({"train_freq": 7}, 14),  # after 105, 112, ..., 196 decisions
        ({"train_freq": 10, "gradient_steps": 3}, 30),
        ({"train_freq": 10, "gradient_steps": -1}, 100),
        ({"num_envs": 4}, 25),
        ({"num_envs": 4, "train_freq": 5, "gradient_steps": -1}, 100),
        ({"learning_starts": 0}, 200),
        ({"learning_starts": 500}, 0),
        ({"gradient_steps": 0}, 0),
    ],
)
def test_updates_come_as_often_as_said(updates, given, count):
    """After a budget of 200 decisions over all envs."""
    train(SacFast(**SMALL, **given), 200)
    assert len(updates) == count


def test_first_decisions_are_uniform(monkeypatch):
    """Until learning starts: no actor is asked, and the box is filled."""
    taken = []

    class Watched(Replay):
        def add(self, observation, action, *rest):
            taken.append(action)
            super().add(observation, action, *rest)

    monkeypatch.setattr(training, "Replay", Watched)
    monkeypatch.delattr(training, "forward")
    train(SacFast(**SMALL, learning_starts=200), 200)
    actions = np.concatenate(taken)
    assert_allclose(np.quantile(actions, [0.0, 0.25, 0.5, 0.75, 1.0]), [-1.0, -0.5, 0.0, 0.5, 1.0], atol=0.1)


def test_a_cut_episode_goes_on_from_its_last_observation(monkeypatch):
    """Not from the first of the next one; it is not terminated."""
    kept = []

    class Watched(Replay):
        def add(self, *args):
            kept.append(tuple(np.array(arg) for arg in args))
            super().add(*args)

    monkeypatch.setattr(training, "Replay", Watched)
    train(SacFast(**SMALL), 45)  # episodes of 20 steps
    observation, _, following, _, terminated = (np.concatenate(column) for column in zip(*kept, strict=True))
    assert [index for index in range(1, 45) if not np.array_equal(observation[index], following[index - 1])] == [20, 40]
    assert not terminated.any()


def test_a_reached_target_terminates(updates):
    """Where an episode ends at its target nothing is expected to follow; where it is cut, it is."""
    env = ReachVectorEnv(IdealSimulator(), easy_robot(), replace(EASY, epsilon=0.6), NegativeDistance())
    env.reset(seed=ENV_SEED)
    SacFast(**SMALL, learning_starts=10).train(env, 100, 0, Progress())
    ended = np.concatenate([batch.goes_on == 0.0 for batch in updates])
    paid = np.concatenate([batch.reward for batch in updates])
    assert ended.any()
    assert_array_equal(ended, paid > 0.0)  # minus the distance, and 1 for the target


def test_policy_is_the_actor():
    """The mean of the last actor, squashed."""
    env = WatchedEnv(1)
    observation, _ = env.reset(seed=ENV_SEED)
    run = training.Training(SacFast(**SMALL), env, 150, 0, Progress())
    policy = run.run()
    hidden = np.maximum(np.append(observation, np.ones((1, 1), np.float32), axis=1) @ run._learner.actor[0][0], 0.0)
    mean = np.append(hidden, np.ones((1, 1), np.float32), axis=1) @ run._learner.actor[1][0][:, :6]
    assert_allclose(policy.act(observation), np.tanh(mean), rtol=1e-5)


def test_every_update_changes_the_policy():
    """And each policy that is told is a copy, which stays as it was."""
    told = Told()
    train(SacFast(**SMALL), 103, told)
    weights = [policy.weights["mean.weight"] for _, policy in told.policies]  # type: ignore[attr-defined]
    assert [steps for steps, _ in told.policies] == [*range(1, 104), 103]
    assert [not np.array_equal(one, other) for one, other in pairwise(weights)] == [False] * 99 + [True] * 3 + [False]


def test_progress_is_told_every_hundred_steps_and_at_the_end():
    """No more often: a line each is passed on to the caller."""
    told = Told()
    train(SacFast(**SMALL), 250, told)
    assert told.steps == [100, 200, 250]


def test_scalars_have_the_names_of_the_others():
    """Of losses, each thousand steps and at the end."""
    told = Told()
    train(SacFast(**SMALL), 1_040, told)
    assert [steps for steps, _ in told.told] == [1_000, 1_040]
    for _, values in told.told:
        assert set(values) == {
            "Losses/Policy Loss", "Losses/Value Loss", "Policy/Entropy", "Policy/Continuous Entropy Coeff",
            "Policy/Learning Rate",
        }  # fmt: skip
        assert np.isfinite(list(values.values())).all()


def test_buffer_is_no_larger_than_the_budget(monkeypatch):
    """A million transitions are not asked for where 50 are made."""
    asked = []
    real = training.Replay
    monkeypatch.setattr(training, "Replay", lambda *args: asked.append(args[0]) or real(*args))
    train(SacFast(**SMALL), 50)
    train(SacFast(**SMALL, buffer_size=30), 50)
    assert asked == [50, 30]


@pytest.mark.parametrize(
    "given",
    [
        {},
        {"train_freq": 7, "learning_starts": 20},
        {"num_envs": 4, "train_freq": 5, "gradient_steps": -1},
        {"train_freq": 10, "gradient_steps": 3, "learning_starts": 30},
        {"learning_starts": 0},
    ],
    ids=str,
)
def test_updates_come_when_the_library_makes_them(given, monkeypatch):
    """After the same decisions, as many each time."""
    env, made = WatchedEnv(given.get("num_envs", 1)), {Sac: list[int](), SacFast: list[int]()}
    env.reset(seed=ENV_SEED)
    start = 0

    def note(_, gradient_steps, batch_size):
        made[Sac] += [env.environment_steps - start] * gradient_steps

    class Noted(Learner):
        def update(self, batch):
            made[SacFast].append(env.environment_steps - start)
            return super().update(batch)

    monkeypatch.setattr(stable_baselines3.SAC, "train", note)
    monkeypatch.setattr(training, "Learner", Noted)
    for algorithm in made:
        start = env.environment_steps
        algorithm(**SMALL, **given).train(env, 120, 0, Progress())
    assert made[SacFast]
    assert made[SacFast] == made[Sac]
