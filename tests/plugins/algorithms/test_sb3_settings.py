"""Every hyperparameter arrives at stable-baselines3, and what cannot be is refused."""

import pytest

from harness.registry import build, choose
from harness_plugins.algorithms.ddqn import Ddqn
from harness_plugins.algorithms.dqn import Dqn
from harness_plugins.algorithms.ppo import Ppo
from harness_plugins.algorithms.td3 import Td3
from harness_plugins.kit.trainings import train_anew
from tests.refusals import refused
from tests.registered import REGISTRY

SHARED = {
    "learning_rate": 0.002, "gamma": 0.9, "net_arch": (32, 16), "batch_size": 17, "buffer_size": 100,
    "learning_starts": 11, "train_freq": 2, "gradient_steps": 3, "tau": 0.02, "num_envs": 2,
}  # fmt: skip


def model_of(models, algorithm):
    """The model that a short training with seed 5 makes."""
    train_anew(algorithm, 40, seed=5)
    (model,) = models
    assert (model.seed, model.device.type, model.n_envs) == (5, "cpu", algorithm.num_envs)
    return model


def require_shared(model, activation):
    """What `SHARED` says is what the model has."""
    assert (model.learning_rate, model.gamma, model.batch_size, model.tau) == (0.002, 0.9, 17, 0.02)
    assert (model.learning_starts, model.train_freq.frequency, model.gradient_steps) == (11, 2, 3)
    assert model.buffer_size == 40
    assert model.policy_kwargs["net_arch"] == [32, 16]
    assert model.policy_kwargs["activation_fn"].__name__ == activation


def test_settings_of_td3(models):
    """TD3's."""
    given = {"action_noise": 0.3, "policy_delay": 3, "target_noise": 0.1, "target_noise_clip": 0.4}
    model = model_of(models, Td3(**SHARED, **given, activation="tanh"))
    require_shared(model, "Tanh")
    assert (model.policy_delay, model.target_policy_noise, model.target_noise_clip) == (3, 0.1, 0.4)
    assert model.action_noise.noises[0]._sigma.tolist() == [0.3] * 6


@pytest.mark.parametrize("algorithm", [Dqn, Ddqn])
def test_settings_of_q_learning(models, algorithm):
    """A deep Q network's."""
    given = {"target_update_interval": 5, "exploration_fraction": 0.5, "exploration_start": 0.9, "exploration_end": 0.1}
    model = model_of(models, algorithm(**SHARED, **given, max_gradient=3.0, activation="relu"))
    require_shared(model, "ReLU")
    assert (model.target_update_interval, model.exploration_fraction, model.max_grad_norm) == (5, 0.5, 3.0)
    assert (model.exploration_initial_eps, model.exploration_final_eps) == (0.9, 0.1)


def test_settings_of_ppo(models):
    """PPO's; `rollout` is over all envs."""
    algorithm = Ppo(
        learning_rate=0.002, gamma=0.9, net_arch=(32, 16), batch_size=4, rollout=20, epochs=2, gae_lambda=0.8,
        clip_range=0.1, ent_coef=0.01, value_coef=0.6, log_std=-2.0, max_gradient=0.7, activation="relu", num_envs=2,
    )  # fmt: skip
    model = model_of(models, algorithm)
    assert (model.learning_rate, model.gamma, model.batch_size, model.n_steps) == (0.002, 0.9, 4, 10)
    assert (model.n_epochs, model.gae_lambda, model.ent_coef, model.vf_coef) == (2, 0.8, 0.01, 0.6)
    assert (model.clip_range(0.5), model.max_grad_norm, model.policy_kwargs["log_std_init"]) == (0.1, 0.7, -2.0)
    assert model.policy_kwargs["activation_fn"].__name__ == "ReLU"


def test_linear_schedule_ends_at_zero(models):
    """Learning rate and clip_range at half of the training are half of what they were."""
    model = model_of(models, Ppo(rollout=40, batch_size=10, schedule="linear", learning_rate=0.002, clip_range=0.2))
    assert model.lr_schedule(0.5) == pytest.approx(0.001)
    assert model.clip_range(0.5) == pytest.approx(0.1)


def test_published_settings_are_a_preset():
    """Batch 256, buffer 2560 in segments of 128, 3 layers of 256, learning rate 3e-4 that decays, gamma 0.99."""
    ppo = Ppo(preset="unity")
    assert (ppo.batch_size, ppo.rollout, ppo.rollout // ppo.num_envs) == (256, 2560, 128)
    assert (ppo.net_arch, ppo.learning_rate, ppo.schedule, ppo.gamma) == ((256,) * 3, 3e-4, "linear", 0.99)


@pytest.mark.parametrize("given", [{"learning_rate": 1e-3}, {"gamma": 0.5}, {"batch_size": 64}, {"epochs": 10}])
def test_what_is_given_wins_over_the_preset(given):
    """Also where it is what the parameter has by default."""
    values = vars(build(Ppo, {"preset": "unity", **given}, "algorithm 'ppo'"))
    assert {key: values[key] for key in given} == given
    assert {**vars(Ppo(preset="unity")), **given} == values


@pytest.mark.parametrize(
    "text", ["ppo", "ppo:preset=unity", "ppo:preset=unity,learning_rate=0.001", "ppo:preset=unity,num_envs=10"]
)
def test_label_names_the_preset_and_what_differs_from_it(text):
    """Every parameter is recorded with its value all the same, and the record gives the same choice again."""
    choice = choose(REGISTRY, "algorithms", text)
    assert choice.label == text
    assert choose(REGISTRY, "algorithms", {"name": "ppo", **dict(choice.params)}) == choice


def test_bad_setting_is_a_usage_error(subtests):
    """A hyperparameter that cannot be is refused before anything runs."""
    for algorithm, given in [
        (Td3, {"action_noise": -0.1}),
        (Td3, {"policy_delay": 0}),
        (Td3, {"gamma": 1.5}),
        (Dqn, {"exploration_end": 1.1}),
        (Dqn, {"target_update_interval": 0}),
        (Ddqn, {"net_arch": ""}),
        (Ppo, {"preset": "unreal"}),
        (Ppo, {"clip_range": 0}),
        (Ppo, {"rollout": 100}),
        (Ppo, {"num_envs": 5}),
        (Ppo, {"preset": "unity", "batch_size": 100}),
    ]:
        with subtests.test(algorithm=algorithm), refused(list(given)[-1]):
            build(algorithm, given, "algorithm")
