"""What is told and paid."""

from collections.abc import Callable
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.testing import assert_allclose, assert_array_equal

from harness.task import ReachTask
from harness_plugins.kit.trainings import NegativeDistance
from tests.env.conftest import CountsSteps

Call = Callable[..., Any]


def test_infos_of_every_step(make, wander):
    """Every step tells distance, shaped reward and success of every env."""
    observations, _, _, _, infos = wander(make(2, seed=0), 1)[0]
    assert set(infos) == {"distance", "reward_shaped", "is_success"}
    assert_allclose(infos["distance"], observations[:, -1], atol=1e-6)
    assert_array_equal(infos["reward_shaped"], -infos["distance"])
    assert infos["is_success"].dtype == bool


def test_rewards_are_float64(make, stand):
    """What is paid is recorded and summed over whole runs: it is not rounded to float32."""
    assert stand(make(2, seed=0))[1].dtype == np.float64


def test_reward_sees_one_sample_per_step(make, wander):
    """The sample is begin distance, best before the step, last distance, distance, their difference, and t."""
    samples = []

    class Spy(NegativeDistance):
        def __call__(self, carry, sample):
            samples.append([float(part[0]) for part in sample])
            return carry, -sample.distance

    env = make(task=ReachTask(horizon=5), reward=Spy())
    samples.clear()  # made-up steps, which show what a reward reads
    _, infos = env.reset(seed=0)
    distances = [infos["distance"][0], *(infos["distance"][0] for *_, infos in wander(env, 5))]
    for t in range(1, 6):
        best = min(distances[:t])
        expected = [distances[0], best, distances[t - 1], distances[t], distances[t] - best, t]
        assert_allclose(samples[t - 1], expected, rtol=1e-12)


def test_carry_starts_anew_with_an_episode(make, stand, wander):
    """What a reward remembers is forgotten for the arms that start, and kept for the others."""
    env = make(2, ReachTask(horizon=9), reward=CountsSteps(), autoreset_mode=AutoresetMode.DISABLED, seed=0)
    wander(env, 2)
    env.reset(options={"reset_mask": np.array([True, False])})
    assert_array_equal(stand(env)[-1]["reward_shaped"], [1.0, 3.0])
