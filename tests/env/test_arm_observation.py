"""What the learner sees: NOTE Table I and where the target is, each in its place and scale."""

import numpy as np
import pytest
from numpy.linalg import norm
from numpy.testing import assert_allclose, assert_array_equal

from harness.env.arm_observation import ArmObservation
from harness.env.vector_env import ReachVectorEnv
from harness.task import ReachTask
from harness_plugins.kit import IdealSimulator
from harness_plugins.kit.trainings import NegativeDistance
from tests.registered import FD100 as ROBOT

PERIOD = 0.1
ANGLES, SPEEDS, ACCELERATIONS = slice(0, 6), slice(6, 12), slice(12, 18)
TARGET, END_EFFECTOR, OFFSET, DISTANCE = slice(18, 21), slice(21, 24), slice(24, 27), 27


@pytest.fixture
def env():
    """Two arms that go exactly where they are told."""
    env = ReachVectorEnv(IdealSimulator(), ROBOT, ReachTask(control_period=PERIOD), NegativeDistance(), num_envs=2)
    env.reset(seed=3)
    return env


def step(env, action):
    """The observations after one action for all joints."""
    return env.step(np.full((2, 6), action, np.float32))[0]


def test_bounds_fit_the_table():
    """Joint numbers are in [-1, 1], a distance is not negative, and no position is beyond the arm's reach."""
    observation = ArmObservation(ROBOT, PERIOD)
    assert_array_equal(observation.low[:18], -1.0)
    assert_array_equal(observation.high[:18], 1.0)
    assert observation.low[DISTANCE] == 0.0
    assert (observation.high[18:] > ROBOT.reach).all()
    assert observation.low.shape == observation.high.shape == (28,)  # 18 of the table, three positions, a distance
    assert observation.low.dtype == observation.high.dtype == np.float32


def test_angles_are_positions_in_the_range(env):
    """-1 is the lower end of a joint's range, 1 the upper."""
    seen = step(env, 0.5)
    expected = 2.0 * (env.simulation.read().qpos - ROBOT.lower) / (ROBOT.upper - ROBOT.lower) - 1.0
    assert_allclose(seen[:, ANGLES], expected, atol=1e-6)


@pytest.mark.parametrize(
    ("steps", "action", "part", "share"),
    [(3, 0.25, SPEEDS, 0.2), (1, 1.0, ACCELERATIONS, 0.6), (4, 0.25, ACCELERATIONS, 0.0)],
)
def test_motion_is_told_as_fractions_of_the_maximum(env, steps, action, part, share):
    """80 % of a speed that was asked for; 60 % of an acceleration in the first period, none in steady motion."""
    for _ in range(steps):
        seen = step(env, action)
    assert_allclose(seen[:, part], share, atol=1e-6)


def test_arm_rests_at_the_start(env):
    """An episode starts without speed and acceleration, also after another one."""
    step(env, 1.0)
    seen, _ = env.reset()
    assert_array_equal(seen[:, SPEEDS], 0.0)
    assert_array_equal(seen[:, ACCELERATIONS], 0.0)


def test_end_effector_is_in_the_world_frame(env):
    """The end effector is where the robot's kinematics put it, [m]."""
    seen = step(env, -0.7)
    expected = ROBOT.end_effector(env.simulation.read().qpos)
    assert_allclose(seen[:, END_EFFECTOR], expected, atol=1e-6)


def test_offset_leads_to_the_target(env):
    """Target = end effector + offset, and the distance is the offset's length."""
    seen = step(env, -0.7)
    assert_allclose(seen[:, TARGET], seen[:, END_EFFECTOR] + seen[:, OFFSET], atol=1e-6)
    assert_allclose(seen[:, DISTANCE], norm(seen[:, OFFSET], axis=1), atol=1e-6)


def test_target_stands_still_in_an_episode(env):
    """The target that is seen is the same at every step, and another in the next episode."""
    first = step(env, 0.1)[:, TARGET]
    assert_array_equal(step(env, 0.1)[:, TARGET], first)
    assert (env.reset()[0][:, TARGET] != first).any(axis=1).all()


def test_joint_numbers_are_clipped():
    """A joint beyond its range or its speed, as an engine may have it, is seen at the bound."""

    class Overshooting(IdealSimulator):
        def open(self, robot, num_envs, control_period):
            simulation = super().open(robot, num_envs, control_period)
            drive = simulation.drive
            simulation.drive = lambda qpos, duration: drive(qpos + 10.0, duration)
            return simulation

    env = ReachVectorEnv(Overshooting(), ROBOT, ReachTask(ground_reward=0.0), NegativeDistance(), num_envs=2)
    env.reset(seed=3)
    seen, *_, infos = env.step(np.zeros((2, 6), np.float32))
    seen = infos.get("final_obs", seen)
    assert_array_equal(seen[:, :18], 1.0)
