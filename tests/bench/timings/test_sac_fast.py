"""What `sac-fast` gains over stable-baselines3, on the same physics, settings and number of threads: one."""

from unittest import mock

import pytest

import harness
from harness.algorithm import Progress
from harness.env.vector_env import ReachEnv
from harness_plugins.algorithms.sac import Sac
from harness_plugins.algorithms.sac_fast import SacFast
from harness_plugins.fast_sac.training import Learner
from tests.bench.timings.bare import bare_training

pytestmark = pytest.mark.bench
START = 10
"""Decisions before the first update, of both; from then on one update per step."""


@pytest.mark.parametrize(("width", "full", "at_least"), [(64, 400, 1.9), (256, 120, 1.2)], ids=["64", "256"])
def test_sac_fast_beside_the_bare_library(require_speed, amount, width, full, at_least):
    """With two layers of 64 it is 3.8 times as fast as bare stable-baselines3, with two of 256 1.6 times.

    Half of that, and 0.75, are held: how fast torch is differs from machine to machine.
    """
    settings, steps = SacFast(net_arch=(width, width), learning_starts=START), amount(full, START + 2)
    bare = bare_training(Sac(net_arch=(width, width), learning_starts=START), [ReachEnv()], steps, 0)

    def fast():
        env = harness.make_env("mujoco", "fd100-reach")
        env.reset(seed=0)
        settings.train(env, steps, 0, Progress())
        assert env.environment_steps == steps

    with mock.patch.object(Learner, "update", autospec=True, side_effect=Learner.update) as update:
        fast()
    assert update.call_count == steps - START
    require_speed(bare, fast, at_least, rounds=5)
