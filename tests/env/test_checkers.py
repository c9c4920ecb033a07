"""Gymnasium's and stable-baselines3's checkers on every task with every action mode; warnings are errors."""

from contextlib import contextmanager

import gymnasium
import pytest
from gymnasium.utils.env_checker import check_env
from stable_baselines3.common import env_checker

from harness.motion.modes import MODES
from tests.registered import REGISTRY

INNER = [f"discrete:action={mode}" for mode in MODES if mode != "discrete"]
ACTIONS = [*MODES, *INNER]


every_task = pytest.mark.parametrize("task", REGISTRY.names("tasks"))


@contextmanager
def opened(task, action):
    """One arm, the task's own, on the kinematic simulator."""
    given = {"name": task, "action": action}
    made = gymnasium.make("harness/Reach-v0", simulator="kinematic", task=given, reward="arp:k2=2")
    yield made.unwrapped
    made.close()


@every_task
def test_gymnasium_finds_no_fault(task, subtests):
    """Gymnasium's checker passes without a warning."""
    for action in ACTIONS:
        with subtests.test(action), opened(task, action) as env:
            check_env(env, skip_render_check=True)


@every_task
def test_stable_baselines3_finds_no_fault(task, subtests):
    """stable-baselines3's checker passes without a warning."""
    for action in ACTIONS:
        with subtests.test(action), opened(task, action) as env:
            env_checker.check_env(env, warn=True, skip_render_check=True)


@pytest.mark.parametrize("simulator", ["mujoco", "pybullet", "dm_control"])
def test_every_simulator_passes(simulator):
    """Whatever moves the arm."""
    made = gymnasium.make("harness/Reach-v0", simulator=simulator, task="fd100-reach:horizon=20", reward="baseline")
    check_env(made.unwrapped, skip_render_check=True)
    made.close()
