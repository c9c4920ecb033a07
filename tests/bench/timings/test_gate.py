"""What the gate for numbers takes of a cell in an environment, and of the steps of arms."""

import shutil
from unittest import mock

import numpy as np
import pytest
from numpy.random import default_rng

import harness
from harness import load_registry
from harness.experiment.plan import check_experiment, expand
from harness.experiment.run_cell import run_cell

pytestmark = pytest.mark.bench
STEPS = 20_000


def _without(place, unseen):
    """Runs a function with another one in a module's place, which lets all pass unseen."""

    def run(function):
        with mock.patch(place, unseen):
            function()

    return run


def test_a_cell_in_pendulum(require_speed, amount, tmp_path):
    """A training by chance, which is the quickest, and a short evaluation: 5 % at most."""
    asked = {"task": "gymnasium:id=Pendulum-v1", "algo": "random", "reward": [], "evaluation_episodes": 1}
    (cell,) = expand(check_experiment({**asked, "seeds": 1, "steps": amount(STEPS, 20)}), load_registry()).cells

    def do():
        assert run_cell(cell, tmp_path / "cell", lambda word: None).status == "done"
        shutil.rmtree(tmp_path / "cell")

    bare = _without("harness.experiment.environments.world.Gate", lambda env, where: env)
    require_speed(lambda: bare(do), do, 1 / 1.05)


@pytest.mark.parametrize(("envs", "steps", "most"), [(1, 10_000, 0.04), (64, 300, 0.01), (1024, 20, 0.01)])
def test_steps_of_arms(require_speed, step_through, amount, envs, steps, most):
    """In MuJoCo, under random actions."""
    env = harness.make_env("mujoco", num_envs=envs)
    actions = default_rng(0).uniform(-1.0, 1.0, (amount(steps, 2), envs, 6)).astype(np.float32)

    def go():
        env.reset(seed=0)
        step_through(env, actions)

    bare = _without("harness.env.decisions.is_finite", lambda numbers: True)
    require_speed(lambda: bare(go), go, 1 / (1 + most))
