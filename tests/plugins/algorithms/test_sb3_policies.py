"""What stable-baselines3 learned is what the saved policy does, for every algorithm and kind of action."""

import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.algorithm import Progress
from harness.policy import Categorical, Deterministic, Gaussian, Greedy, load_policy
from harness_plugins.algorithms.ddqn import Ddqn
from harness_plugins.algorithms.dqn import Dqn
from harness_plugins.algorithms.ppo import Ppo
from harness_plugins.algorithms.sac import Sac
from harness_plugins.algorithms.td3 import Td3
from harness_plugins.kit.algorithms import the_budget_is_spent_exactly
from harness_plugins.kit.trainings import WatchedEnv, observations, train_anew

STEPS = 160
QUICK_PPO = {"rollout": 32, "batch_size": 16, "num_envs": 1}
CONTINUOUS = [Sac(), Td3(), Td3(activation="tanh", net_arch=(8, 16)), Ppo(**QUICK_PPO), Ppo(activation="relu")]
DISCRETE = [Dqn(), Ddqn(), Dqn(activation="tanh", net_arch=(16,)), Ppo(**QUICK_PPO), Ppo(net_arch=(8, 16, 24))]
EVERY = [
    *((algorithm, "continuous") for algorithm in CONTINUOUS),
    *((algorithm, "discrete") for algorithm in DISCRETE),
]


def trained(algorithm, space="continuous"):
    """A training that is long enough for updates."""
    return train_anew(algorithm, STEPS, space=space)


@pytest.mark.parametrize(("algorithm", "space"), EVERY, ids=repr)
def test_policy_acts_as_the_model(models, tmp_path, algorithm, space):
    """Saved and loaded, the policy's actions are those of stable-baselines3's model without noise, to 1e-6."""
    trained(algorithm, space).policy.save(tmp_path / "policy")
    seen = observations()
    expected, _ = models[0].predict(seen, deterministic=True)
    assert_allclose(load_policy(tmp_path / "policy").act(seen), expected, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize(("algorithm", "space"), EVERY, ids=repr)
def test_weights_are_copies(models, algorithm, space):
    """What the model does next does not change a policy that was yielded."""
    policy = trained(algorithm, space).policy
    before = {name: weight.copy() for name, weight in policy.weights.items()}
    for parameter in models[0].policy.parameters():
        parameter.data += 1.0
    for name, weight in policy.weights.items():
        assert_array_equal(weight, before[name])


def test_ppo_draws_as_the_model(models):
    """With noise, mean and spread of the actions are those of stable-baselines3's Gaussian, cut to the box."""
    policy = trained(Ppo(**QUICK_PPO)).policy
    assert isinstance(policy, Gaussian)
    seen = np.repeat(observations()[:1], 20_000, axis=0)
    ours = policy.act(seen, default_rng(0))
    theirs, _ = models[0].predict(seen, deterministic=False)
    assert_allclose(ours.mean(axis=0), theirs.mean(axis=0), atol=0.03)
    assert_allclose(ours.std(axis=0), theirs.std(axis=0), atol=0.02)


def test_ppo_chooses_as_the_model(models):
    """With noise, every choice is made as often as by stable-baselines3's categorical distribution."""
    policy = trained(Ppo(**QUICK_PPO), "discrete").policy
    assert isinstance(policy, Categorical)
    seen = np.repeat(observations()[:1], 20_000, axis=0)
    theirs, _ = models[0].predict(seen, deterministic=False)
    shares = [np.bincount(given, minlength=13) / 20_000 for given in (policy.act(seen, default_rng(0)), theirs)]
    assert_allclose(*shares, atol=0.02)


def test_policies_draw_with_the_noise_of_the_training():
    """TD3's noise is what it added to actions, a deep Q network's share of random choices that of its end."""
    td3 = trained(Td3(action_noise=0.3)).policy
    assert isinstance(td3, Deterministic)
    assert td3.noise == 0.3
    dqn = trained(Dqn(exploration_end=0.2), "discrete").policy
    assert isinstance(dqn, Greedy)
    assert dqn.epsilon == 0.2


def test_budget_is_spent_exactly(subtests):
    """Neither the number of envs nor the rhythm of the updates makes a training longer than its budget."""
    for algorithm in [
        Td3(num_envs=4),
        Td3(num_envs=4, train_freq=3),
        Dqn(num_envs=4),
        Ddqn(train_freq=7),
        Ppo(num_envs=4),
        Ppo(rollout=60, batch_size=20, num_envs=3),
        Ppo(rollout=500, batch_size=50, num_envs=1),
    ]:
        with subtests.test(algorithm=algorithm):
            the_budget_is_spent_exactly(algorithm)


@pytest.mark.parametrize("algorithm", [Sac(), Td3(), Ppo(num_envs=1), Dqn(), Ddqn()], ids=repr)
def test_large_seed_is_taken(algorithm):
    """A seed of 64 bits is no error."""
    assert train_anew(algorithm, 4, seed=2**63).env.steps == 4


@pytest.mark.parametrize(("algorithm", "space"), [(Sac(), "continuous"), (Ppo(**QUICK_PPO), "discrete")], ids=repr)
def test_looking_on_changes_nothing(algorithm, space):
    """A policy that is taken at every step, as for evaluations, leaves the training as it is, bit for bit."""

    class Curious(Progress):
        def policy(self, steps, make):
            make()

    env = WatchedEnv(1, space)
    env.reset(seed=7)
    watched = algorithm.train(env, STEPS, 0, Curious())
    for name, weight in trained(algorithm, space).policy.weights.items():
        assert_array_equal(weight, watched.weights[name])
