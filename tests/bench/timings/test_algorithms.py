"""What the harness costs on top of stable-baselines3, algorithm by algorithm, on the same physics and settings."""

import pytest

import harness
from harness.algorithm import Progress
from harness.env.vector_env import ReachEnv
from harness.record import TraceWriter
from harness_plugins.algorithms.ddqn import Ddqn
from harness_plugins.algorithms.dqn import Dqn
from harness_plugins.algorithms.ppo import Ppo
from harness_plugins.algorithms.sac import Sac
from harness_plugins.algorithms.td3 import Td3
from tests.bench.timings.bare import bare_training

pytestmark = pytest.mark.bench
DISCRETE = "fd100-reach:action=discrete"
ENOUGH = 128
"""Steps with which each of them learns at least once."""
CASES = {
    "sac": (Sac(), "fd100-reach", 350),
    "td3": (Td3(), "fd100-reach", 500),
    "ppo": (Ppo(), "fd100-reach", 20 * Ppo().rollout),
    "dqn": (Dqn(), DISCRETE, 600),
    "ddqn": (Ddqn(), DISCRETE, 600),
}
"""Algorithm, task and steps."""


@pytest.mark.parametrize("name", CASES)
def test_algorithm_beside_the_bare_one(tmp_path, require_speed, amount, name):
    """Through the harness, trace on, it is nearly as fast as bare stable-baselines3 on the same envs, or faster."""
    settings, task, full = CASES[name]
    steps = amount(full, ENOUGH)
    bare = bare_training(settings, [ReachEnv(task=task) for _ in range(settings.num_envs)], steps, 0)

    def through_the_harness():
        env = harness.make_env(task=task, num_envs=settings.num_envs)
        with TraceWriter(tmp_path / "trace.parquet", env.robot.dof, env.episodes.action.shape[1]) as recorder:
            env.recorder = recorder
            env.reset(seed=0)
            settings.train(env, steps, 0, Progress())
        assert env.environment_steps == steps

    require_speed(bare, through_the_harness, at_least=0.8, rounds=5)
