"""The library without the harness: what a training is timed beside does the same work."""

from unittest import mock

import stable_baselines3

import harness
from harness.algorithm import Progress
from harness.env.vector_env import ReachEnv
from harness_plugins.algorithms.ddqn import Ddqn
from harness_plugins.algorithms.dqn import Dqn
from harness_plugins.algorithms.ppo import Ppo
from harness_plugins.algorithms.sac import Sac
from harness_plugins.algorithms.td3 import Td3
from tests.bench.timings.bare import bare_training

SMALL = {"learning_starts": 4, "batch_size": 8, "net_arch": (8,)}
CONTINUOUS, DISCRETE = "fd100-reach", "fd100-reach:action=discrete"
CASES = {
    "sac": (Sac(**SMALL), stable_baselines3.SAC, CONTINUOUS),
    "td3": (Td3(**SMALL), stable_baselines3.TD3, CONTINUOUS),
    "ppo": (Ppo(rollout=8, batch_size=8, net_arch=(8,), num_envs=1), stable_baselines3.PPO, CONTINUOUS),
    "ppo, 4 envs": (Ppo(rollout=8, batch_size=8, net_arch=(8,), num_envs=4), stable_baselines3.PPO, CONTINUOUS),
    "dqn": (Dqn(**SMALL), stable_baselines3.DQN, DISCRETE),
    "ddqn": (Ddqn(**SMALL), stable_baselines3.DQN, DISCRETE),
}
STEPS = 16


def test_the_bare_training_updates_as_often_as_ours(subtests):
    """Of as many steps; each call trains a new model."""
    for name, (algorithm, library, task) in CASES.items():
        with subtests.test(name=name):
            with mock.patch.object(library, "train", autospec=True, side_effect=library.train) as update:
                env = harness.make_env("kinematic", task, num_envs=algorithm.num_envs)
                env.reset(seed=0)
                algorithm.train(env, STEPS, 0, Progress())
                ours = [call.args[1:] + tuple(call.kwargs.items()) for call in update.mock_calls]
                update.reset_mock()
                envs = [ReachEnv("kinematic", task) for _ in range(algorithm.num_envs)]
                bare = bare_training(algorithm, envs, STEPS, 0)
                assert not update.called
                bare()
                first, models = len(update.mock_calls), {id(call.args[0]) for call in update.mock_calls}
                bare()
            assert first == len(ours) > 0
            assert len(update.mock_calls) == 2 * first
            assert len(models) == 1


def test_a_model_without_torch_leaves_no_checkpoint():
    """What it has learned would not be in it: sbx says that it has no parameters of PyTorch's."""
    from harness_plugins.sb3 import ProgressCallback, VecEnvAdapter, policy_from

    class Offered(Progress):
        offered = 0

        def checkpoint(self, steps, make):
            self.offered += 1

    counts = []
    for names in (None, ([], [])):
        env, told = harness.make_env("kinematic"), Offered()
        env.reset(seed=0)
        model = stable_baselines3.SAC(
            "MlpPolicy", VecEnvAdapter(env), buffer_size=9, device="cpu", policy_kwargs={"net_arch": [8]}
        )
        if names is not None:
            model._get_torch_save_params = lambda names=names: names
        model.learn(4, callback=ProgressCallback(env, told, 4, lambda model: policy_from(model, "relu", "mine")))
        counts.append(told.offered)
    assert counts[0] > 0
    assert counts[1] == 0
