"""The baseline's own tasks against the figures that its public sources give, computed here by other ways."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.linalg import norm
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

import harness
from harness.env.vector_env import ReachVectorEnv
from harness_plugins.kit import IdealSimulator
from harness_plugins.kit.trainings import NegativeDistance
from harness_plugins.tasks import unity
from harness_plugins.tasks.unity import Arp2021, UnityReach
from tests.refusals import refused
from tests.registered import UNITY_ARM as ARM

DEGREES = np.array([180.0, 90.0, 180.0, 90.0, 90.0])
UNITY_START_TIP = (-0.185766, 1.049303, 0.1233658)
"""Of the fixed start, as its experimenters wrote it down, Unity's frame."""


def from_unity(point):
    """A point of Unity's left-handed y-up frame in ours."""
    x, y, z = point
    return np.array([z, -x, y])


def rng(seed=0):
    """The same numbers every time."""
    return default_rng(seed)


def make(task, num_envs=1):
    """An env without an engine."""
    return ReachVectorEnv(IdealSimulator(), ARM, task, NegativeDistance(), num_envs)


# The published experiment


def test_fixed_start_gives_the_recorded_tip():
    """(-18, 9, -18, 9, 9) degrees, whatever is drawn, and the end effector where the experimenters had it."""
    start = Arp2021().draw_start(ARM, rng())
    assert_allclose(np.degrees(start), [-18, 9, -18, 9, 9], rtol=1e-12)
    assert_allclose(ARM.end_effector(start), from_unity(UNITY_START_TIP), atol=1e-6)


def test_fixed_target_is_the_published_one():
    """Base + (0.45, 0.2, 0.45) of Unity, every time, in the world."""
    position, relative = Arp2021().draw_targets(ARM, rng(), 5)
    assert_array_equal(position, [from_unity((0.45, 0.2, 0.45))] * 5)
    assert_array_equal(position[0], [0.45, -0.45, 0.2])
    assert not relative.any()


def test_begin_distance_is_the_published_one():
    """Of the two points: the K2 data files begin with 1.110047."""
    _, infos = make(Arp2021()).reset(seed=0)
    expected = norm(np.subtract((0.45, 0.2, 0.45), UNITY_START_TIP))
    assert infos["distance"][0] == pytest.approx(expected, abs=1e-6)


def test_arm_that_does_not_reach_the_target_is_refused(monkeypatch):
    """Said before anything is run, with what to take instead."""
    monkeypatch.setattr(unity, "FIXED_TARGET", np.array([3.0, 0.0, 0.2]))
    with refused(r"unity-arm does not reach the fixed target \(3.0, 0.0, 0.2\) m"):
        Arp2021().check(ARM)


# The random variant


def test_random_targets_are_in_the_published_boxes():
    """Half from the base within U([0.3, 0.6] x [0.1, 0.3] x [0.3, 0.6]), half from the tip within U([0.01, 0.15]^3)."""
    position, relative = UnityReach().draw_targets(ARM, rng(), 4000)
    x, y, z = -position[:, 1], position[:, 2], position[:, 0]  # Unity's axes
    unity = np.stack([x, y, z], axis=1)
    assert relative.mean() == pytest.approx(0.5, abs=0.03)
    for part, low, high in ((relative, [0.01] * 3, [0.15] * 3), (~relative, [0.3, 0.1, 0.3], [0.6, 0.3, 0.6])):
        drawn = unity[part]
        assert (drawn >= low).all()
        assert (drawn <= high).all()
        span = np.subtract(high, low)
        assert (drawn.min(axis=0) < low + 0.02 * span).all()
        assert (drawn.max(axis=0) > high - 0.02 * span).all()
        assert_allclose(drawn.mean(axis=0), np.add(low, high) / 2.0, atol=0.02 * span.max())


def test_starts_are_in_the_published_heights():
    """Uniform in the joint ranges, redrawn until the tip is 0.1 to 1 m above the ground."""
    generator = rng()
    starts = np.array([UnityReach().draw_start(ARM, generator) for _ in range(400)])
    height = ARM.end_effector(starts)[:, 2]
    assert height.min() >= 0.1
    assert height.max() <= 1.0
    assert (np.abs(starts) <= np.radians(DEGREES)).all()
    assert (np.abs(starts).max(axis=0) > 0.95 * np.radians(DEGREES)).all()


def test_start_is_the_last_draw_where_none_is_at_that_height():
    """The search ends after a hundred draws."""

    class Never(np.random.Generator):
        drawn = 0

        def uniform(self, *args, **kwargs):
            self.drawn += 1
            return np.zeros(5) + 1e-9 * self.drawn  # straight up: 1.1 m and more

    generator = Never(np.random.PCG64(0))
    assert ARM.end_effector(np.zeros(5))[2] > 1.0
    assert UnityReach().draw_start(ARM, generator)[0] == pytest.approx(1e-7)


# Actions


@given(st.lists(st.floats(-1.0, 1.0), min_size=5, max_size=5))
def test_action_sets_the_published_angles(action):
    """The joint angles are the action times (180, 90, 180, 90, 90) degrees, at once."""
    move = UnityReach().motion(ARM).advance(ARM.home[None], np.zeros((1, 5)), np.array([action]))
    assert_allclose(np.degrees(move.waypoints[-1][0]), action * DEGREES, rtol=0.0, atol=1e-12)
    assert UnityReach().motion(ARM).jumps


def test_one_action_for_five_steps():
    """A decision every five environment steps; the horizon of 5000 counts those, not decisions."""
    task = Arp2021()
    assert (task.decision_period, task.horizon) == (5, 5000)
    env = make(task)
    env.reset(seed=0)
    action = (ARM.home / ARM.upper).astype(np.float32)[None]
    assert [bool(env.step(action)[3][0]) for _ in range(1000)] == [False] * 999 + [True]
    assert env.environment_steps == 5000


# The observation


def observed(env, action, base):
    """The 19 numbers for one arm, number by number."""
    tip = np.array(ARM.end_effector(np.radians(action * DEGREES)))
    target = env.episodes.target[0]
    numbers = list(action)
    for vector in (base, base + target, base + tip, target - tip):
        length = float(sum(part**2 for part in vector)) ** 0.5
        numbers += [part / length if length else 0.0 for part in vector]
    return [*numbers, float(sum((target - tip) ** 2)) ** 0.5, 0.0]


@pytest.mark.parametrize("base", [(0.0, 0.0, 0.0), (2.0, -3.0, 0.5)])
@pytest.mark.parametrize("task", [UnityReach, Arp2021])
def test_observation_is_the_published_one(task, base):
    """Actions, unit vectors to base, target and end effector in the scene, unit offset, distance, and the step's 0."""
    env = make(task(base_position=base, horizon=30))
    observations, _ = env.reset(seed=1)
    start = np.degrees(env.simulation.read().qpos[0]) / DEGREES
    assert_allclose(observations[0], observed(env, start, np.array(base)), atol=1e-6)
    generator, compared = rng(3), 0
    for _ in range(40):
        action = generator.uniform(-1.0, 1.0, 5).astype(np.float32)
        observations, _, terminated, truncated, _ = env.step(action[None])
        if not (terminated[0] or truncated[0]):
            compared += 1
            assert_allclose(observations[0], observed(env, action.astype(float), np.array(base)), atol=1e-6)
    assert observations.shape == (1, 19)
    assert compared > 10


def test_base_at_the_origin_stays_zero():
    """A zero vector has no direction."""
    observations, _ = make(Arp2021()).reset(seed=0)
    assert_array_equal(observations[0, 5:8], 0.0)


# The robot


@pytest.mark.parametrize("task", [UnityReach, Arp2021])
def test_robot_is_that_of_the_original(task):
    """The unity-arm, which passes the task's check."""
    assert task.robot == "unity-arm"
    task().check(ARM)


# Simulators


@pytest.mark.parametrize("simulator", ["kinematic", "mujoco", "pybullet", "dm_control"])
def test_every_simulator_puts_the_tip_at_the_same_place(simulator):
    """The arm jumps: the end effector is that of the robot's kinematics, to a micrometre."""
    env = harness.make_env(simulator, "arp-2021")
    env.reset(seed=0)
    generator = rng(7)
    for _ in range(50):
        action = generator.uniform(-1.0, 1.0, (1, 5)).astype(np.float32)
        *_, infos = env.step(action)
        if "final_obs" not in infos:
            expected = ARM.end_effector(np.radians(action[0].astype(float) * DEGREES))
            assert_allclose(env.simulation.read().end_effector[0], expected, rtol=0.0, atol=1e-6)
    env.close()


@pytest.mark.parametrize("simulator", ["mujoco", "pybullet", "dm_control"])
def test_every_simulator_pays_the_same(simulator):
    """As the kinematic one, over 50 decisions whose contacts agree, to a millionth."""
    envs = [harness.make_env(name, "arp-2021", "arp") for name in ("kinematic", simulator)]
    for env in envs:
        env.reset(seed=0)
    generator, paid = rng(5), []
    for _ in range(50):
        action = (ARM.home / ARM.upper + generator.uniform(-0.45, 0.45, 5)).astype(np.float32)[None]
        one, other = (env.step(np.clip(action, -1.0, 1.0)) for env in envs)
        assert_array_equal(one[2], other[2], err_msg="a contact that not both see")
        assert_allclose(one[1], other[1], rtol=0.0, atol=1e-6)
        assert_allclose(one[0], other[0], rtol=0.0, atol=1e-6)
        paid.append(one[1][0])
    assert len(set(paid)) == 50
    for env in envs:
        env.close()


def test_an_episode_is_no_longer_than_a_training():
    """As `--steps` is bounded."""
    with pytest.raises(ValueError, match="less than or equal to 1000000000"):
        UnityReach(horizon=10**20)
