"""SAC: what stable-baselines3 learned is what the saved policy does."""

import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_allclose

from harness.policy import load_policy
from harness.registry import build
from harness_plugins.algorithms.sac import Sac
from harness_plugins.algorithms.sac_fast import SacFast
from harness_plugins.kit.algorithms import the_budget_is_spent_exactly, the_return_rises
from harness_plugins.kit.trainings import observations, train_anew
from tests.refusals import refused

STEPS = 160


@pytest.mark.parametrize("settings", [{}, {"activation": "tanh"}, {"net_arch": (16,)}, {"net_arch": (8, 16, 24)}])
def test_policy_acts_as_the_actor(models, tmp_path, settings):
    """Saved and loaded, the policy's actions are those of stable-baselines3's actor without noise, to 1e-6."""
    train_anew(Sac(**settings), STEPS).policy.save(tmp_path / "policy")
    seen = observations()
    expected, _ = models[0].predict(seen, deterministic=True)
    assert_allclose(load_policy(tmp_path / "policy").act(seen), expected, rtol=0.0, atol=1e-6)
    assert expected.std(axis=0).min() > 1e-3


def test_policy_draws_as_the_actor(models):
    """With noise, mean and spread of the policy's actions are those of stable-baselines3's actor."""
    policy = train_anew(Sac(), STEPS).policy
    seen = np.repeat(observations()[:1], 20_000, axis=0)
    ours = policy.act(seen, default_rng(0))
    theirs, _ = models[0].predict(seen, deterministic=False)
    assert_allclose(ours.mean(axis=0), theirs.mean(axis=0), atol=0.03)
    assert_allclose(ours.std(axis=0), theirs.std(axis=0), atol=0.02)


def test_settings_reach_the_library(models):
    """Every hyperparameter arrives at stable-baselines3."""
    train_anew(
        Sac(
            learning_rate=0.002, gamma=0.9, net_arch=(32, 16), batch_size=17, buffer_size=100, learning_starts=11,
            train_freq=2, gradient_steps=3, tau=0.01, ent_coef="0.2", activation="tanh",
        ),
        20, seed=5,
    )  # fmt: skip
    (model,) = models
    assert (model.learning_rate, model.gamma, model.batch_size, model.tau) == (0.002, 0.9, 17, 0.01)
    assert (model.learning_starts, model.train_freq.frequency, model.gradient_steps) == (11, 2, 3)
    assert (model.ent_coef, model.seed, model.device.type) == (0.2, 5, "cpu")
    assert model.policy_kwargs["net_arch"] == [32, 16]
    assert model.policy_kwargs["activation_fn"].__name__ == "Tanh"


def test_several_envs_are_trained_on_at_once(models):
    """With num_envs=4 the budget is spent over four envs, and updates are made."""
    done = train_anew(Sac(num_envs=4), STEPS)
    assert done.env.num_envs == 4
    assert done.env.steps == STEPS
    assert models[0]._n_updates == (STEPS - 100) // 4


@pytest.mark.slow
def test_several_envs_learn_the_easy_task():
    """With num_envs=4 the return rises as with one, given as many updates."""
    the_return_rises(Sac(num_envs=4, gradient_steps=-1))


@pytest.mark.parametrize("kind", [Sac, SacFast])
@pytest.mark.parametrize("settings", [{"num_envs": 4}, {"train_freq": 7}, {"num_envs": 4, "train_freq": 3}])
def test_budget_is_spent_exactly(kind, settings):
    """Neither the number of envs nor the rhythm of the updates makes a training longer than its budget."""
    the_budget_is_spent_exactly(kind(**settings))


def test_nothing_is_pickled(tmp_path):
    """The policy's folder holds weights as safetensors and a card as JSON, and nothing else."""
    train_anew(Sac(), 20).policy.save(tmp_path / "policy")
    assert sorted(path.name for path in (tmp_path / "policy").iterdir()) == ["card.json", "weights.safetensors"]


def test_bad_setting_is_a_usage_error(subtests):
    """A hyperparameter that cannot be is refused before anything runs."""
    for given in [
        {"learning_rate": 0},
        {"gamma": 1.5},
        {"net_arch": "64x0"},
        {"net_arch": ""},
        {"batch_size": 0},
        {"learning_starts": -1},
        {"train_freq": 0},
        {"gradient_steps": -2},
        {"tau": 0},
        {"ent_coef": "some"},
        {"ent_coef": "auto_0"},
        {"activation": "gelu"},
        {"num_envs": 0},
        {"momentum": 0.9},
    ]:
        with subtests.test(given=given), refused(next(iter(given))):
            build(Sac, given, "algorithm 'sac'")
