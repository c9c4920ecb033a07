"""The task whose target moves."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.linalg import norm
from numpy.testing import assert_allclose

from harness.env.arm_observation import kinematics_policy
from harness.env.vector_env import ReachVectorEnv
from harness.task import Situation
from harness_plugins.kit import IdealSimulator
from harness_plugins.kit.trainings import NegativeDistance
from harness_plugins.tasks.moving import Moving
from tests.registered import FD100 as ROBOT

WAYS = st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3).map(lambda way: np.array([way]))
STEPS = st.integers(0, 1000).map(lambda step: np.array([float(step)]))


def goal(**given):
    """Of the task with these parameters."""
    return Moving(**given).goal(ROBOT)


@given(WAYS, STEPS)
def test_target_stays_on_its_way(way, step):
    """Between its two ends, whenever."""
    moved, length = goal().displacement(way, step)[0], norm(way)
    along = float(moved @ way[0]) / length if length > 1e-6 else 0.0
    assert -1e-9 <= along <= length + 1e-9
    assert norm(np.cross(moved, way[0])) <= 1e-9


@given(WAYS.filter(lambda way: norm(way) > 0.1), STEPS)
def test_target_moves_as_fast_as_it_says(way, step):
    """By speed times period in a step, less where it turns; where its velocity says, but where it turns."""
    task = goal(target_speed=0.2)
    moved = task.displacement(way, step + 1.0) - task.displacement(way, step)
    now = Situation(*(np.zeros((1, 3)),) * 3, way, step, np.zeros(1))
    velocity = task.observe(now)[:, :3]
    assert norm(moved) <= 0.02 + 1e-9
    assert norm(velocity) == pytest.approx(0.2)
    gone = 0.02 * float(step[0]) % (length := float(norm(way)))
    turns_now = min(gone, length - gone) < 1e-6  # rounding decides whether it has turned already
    if norm(moved) > 0.02 - 1e-9 and not turns_now:
        assert_allclose(moved, 0.1 * velocity, atol=1e-9)


def test_target_without_a_way_stays():
    """Both ends are one place."""
    assert not goal().displacement(np.zeros((1, 3)), np.array([7.0])).any()


@pytest.mark.parametrize("steps", [1, 4])
def test_target_is_reached_by_staying_with_it(steps):
    """After so many steps in a row within epsilon, not before; the learner sees how many of them are done."""
    env = ReachVectorEnv(IdealSimulator(), ROBOT, Moving(steps_within=steps, epsilon=0.05), NegativeDistance())
    seen, infos = env.reset(seed=3)
    act = kinematics_policy(env.task, env.robot).act
    near, shares = [], []
    while not infos["is_success"][0]:
        seen, _, terminated, truncated, infos = env.step(act(seen))
        near.append(bool(infos["distance"][0] <= 0.05))
        shares.append(float(infos["final_obs"][0, -1] if terminated[0] else seen[0, -1]))
        assert not truncated[0]
    assert near[-steps:] == [True] * steps
    assert near.index(True) == len(near) - steps
    assert_allclose(shares[-steps:], np.arange(1, steps + 1) / steps, rtol=1e-6)
