"""Noise, delays, obstacles and varied arms in a batch of envs."""

import numpy as np
import pytest
from numpy.linalg import norm
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.conditions.clearance import Clearance
from harness.conditions.varied_robot import draw_robot
from harness.env import surroundings
from harness.env.arm_observation import ArmObservation
from harness.task import ReachTask
from harness_plugins.simulators.kinematic import Kinematic
from tests.registered import FD100 as ROBOT

DOF = ROBOT.dof
WORSE = ReachTask(
    horizon=9,
    joint_noise=0.02,
    target_noise=0.01,
    action_noise=0.1,
    observation_delay=1,
    action_delay=2,
    obstacle_count=2,
    mass_variation=0.2,
    length_variation=0.05,
    variants=3,
)
NEAR_HOME = "0.75x0x0.55x0.05+0.9x0.4x0.6x0.1x0.1x0.3"


def actions(num_envs, steps):
    """The same for an env in any batch."""
    return default_rng(0).uniform(-1.0, 1.0, (steps, 8, DOF)).astype(np.float32)[:, :num_envs]


def told(env, steps=25):
    """Observations, and the record, of each step."""
    seen = [env.reset(seed=3)[0]]
    for action in actions(env.num_envs, steps):
        seen += [env.step(action)[0], env.episodes.record.copy()]
    return seen


@pytest.fixture
def wandered(make, recorded):
    """The trace of arms that wander."""

    def wander(task, num_envs=2, steps=60):
        return recorded(make(num_envs, task), lambda env: [env.step(it) for it in actions(num_envs, steps)])

    return wander


def test_an_env_is_the_same_in_any_batch(make):
    """What env 0 sees and records alone is what it sees and records among others, bit for bit."""
    alone, among = told(make(1, WORSE)), told(make(4, WORSE))
    for one, all_ in zip(alone, among, strict=True):
        assert_array_equal(one[0], all_[0])


def test_another_seed_is_another_world(make):
    """The first observation already."""
    env = make(2, WORSE)
    assert not np.array_equal(env.reset(seed=0)[0], env.reset(seed=1)[0])


def test_an_episode_is_the_same_however_the_one_before_went(make):
    """Its arm, its obstacles, its first noise: episode n depends on the seed alone."""
    one, other = make(1, WORSE), make(1, WORSE)
    firsts = []
    for env, size in ((one, 0.0), (other, 0.3)):
        env.reset(seed=3)
        while env.episodes.episode[0] == 0:
            seen = env.step(np.full((1, DOF), size, np.float32))[0]
        firsts.append(seen)
    assert_array_equal(*firsts)


def begin_alike(plain, varied):
    """As many records, each of which is the plain one in the columns that that has."""
    for usual, more in zip(plain, varied, strict=True):
        assert_array_equal(usual, more[:, : usual.shape[1]])


def test_conditions_that_change_nothing_are_the_plain_task(make):
    """A variation of arms that is next to nothing, and obstacles far away: the same record, bit for bit."""
    plain = told(make(2, ReachTask(horizon=9)))
    begin_alike(plain, told(make(2, ReachTask(horizon=9, obstacles="9x9x9x0.1", observation_delay=0))))


@pytest.mark.parametrize("share", ["mass_variation", "length_variation"])
def test_an_arm_as_drawn_is_the_plain_arm(make, monkeypatch, share):
    """With every factor 1 a simulation for each arm tells what one simulation of all tells, bit for bit."""
    monkeypatch.setattr(surroundings, "draw_robot", lambda conditions, robot, number: robot)
    plain = told(make(3, ReachTask(horizon=9), simulator=Kinematic()))
    varied = told(make(3, ReachTask(horizon=9, **{share: 0.1}), simulator=Kinematic()))
    begin_alike(plain, varied)


def test_noise_has_its_standard_deviation(make):
    """Of angles, speeds, their changes and the target; the end effector is the one of the angles that are seen."""
    task = ReachTask(horizon=400, joint_noise=0.03, speed_noise=0.2, target_noise=0.04, ground_reward=0.0)
    env = make(40, task, seed=0)
    differences = {name: [] for name in ("qpos", "qvel", "qvel_change", "target")}
    for _ in range(100):
        env.step(np.zeros((40, DOF), np.float32))
        seen = env._decisions.around.senses.look()
        for name, found in differences.items():
            found.append(getattr(seen, name) - getattr(env.episodes, name))
        assert_allclose(seen.end_effector, ROBOT.end_effector(seen.qpos), atol=1e-12)
        assert_allclose(seen.offset, seen.target - seen.end_effector)
        assert_allclose(seen.distance, norm(seen.offset, axis=1))
    for name, deviation in (("qpos", 0.03), ("qvel", 0.2), ("qvel_change", 0.2 * np.sqrt(2.0)), ("target", 0.04)):
        assert np.std(differences[name]) == pytest.approx(deviation, rel=0.03)
        assert abs(np.mean(differences[name])) < 0.05 * deviation


def test_noise_is_not_recorded(make):
    """The trace tells the truth, and what the policy asked for."""
    noisy = ReachTask(horizon=9, joint_noise=0.1, target_noise=0.1)
    for usual, more in zip(told(make(2, ReachTask(horizon=9)))[2::2], told(make(2, noisy))[2::2], strict=True):
        assert_array_equal(usual, more)


def test_action_noise_has_its_standard_deviation(make):
    """Added to what the policy asks for, which is what is recorded."""
    env = make(50, ReachTask(horizon=300, action_noise=0.1, ground_reward=0.0), seed=0)
    asked, done = np.full((50, DOF), 0.25), []
    for step in range(60):
        env.episodes.step[:] = step
        done.append(env._decisions.around.senses.act(asked, None) - 0.25)
    assert np.std(done) == pytest.approx(0.1, rel=0.02)
    assert env._decisions.around.senses.act(np.ones((50, DOF)), None).max() <= 1.0
    env.step(asked.astype(np.float32))
    assert_array_equal(env.episodes.action, 0.25)


@pytest.mark.parametrize("delay", [1, 3])
def test_observations_come_so_many_steps_later(make, delay):
    """What is seen is what the plain env showed before; the first observation is repeated."""
    plain = told(make(2, ReachTask(horizon=50)))[1::2]
    first = make(2, ReachTask(horizon=50)).reset(seed=3)[0]
    for step, seen in enumerate(told(make(2, ReachTask(horizon=50, observation_delay=delay)))[1::2]):
        assert_array_equal(seen, first if step < delay else plain[step - delay])


@pytest.mark.parametrize("delay", [1, 4])
def test_actions_work_so_many_steps_later(make, delay):
    """Until then the arm rests; then it does what it was told to."""
    plain, late = make(2, ReachTask(horizon=50)), make(2, ReachTask(horizon=50, action_delay=delay))
    ways = []
    for env in (plain, late):
        env.reset(seed=3)
        way = [env.episodes.qpos.copy()]
        for action in actions(2, 20):
            env.step(action)
            way.append(env.episodes.qpos.copy())
        ways.append(way)
    for step in range(21):
        assert_array_equal(ways[1][step], ways[0][max(0, step - delay)])


def test_resting_under_absolute_actions_is_staying(make):
    """Rest is where the arm stands, not the middle of its range."""
    env = make(1, ReachTask(horizon=50, action_delay=2, action="movej-absolute"), seed=3)
    start = env.episodes.qpos.copy()
    env.step(np.ones((1, DOF), np.float32))
    assert_allclose(env.episodes.qpos, start, atol=1e-9)


def test_touching_an_obstacle_ends_the_episode(wandered):
    """It is paid, recorded apart from the ground, and where it happens follows from the recorded joints."""
    task = ReachTask(horizon=60, obstacles=NEAR_HOME, obstacle_reward=-0.5, step_reward=0.0)
    trace = wandered(task, 8, 120)
    hits = trace["obstacle"]
    assert hits.sum() > 2
    assert not trace["ground"][hits].any()
    assert not trace["reached"][hits].any()
    assert_array_equal(trace["reward_ground"], np.where(hits, -0.5, 0.0) - trace["ground"])
    assert_array_equal(trace["terminated"], hits | trace["ground"] | trace["reached"])
    obstacles = trace["obstacles"].reshape(len(trace), 2, 7)
    near = Clearance(ROBOT).touches(trace["qpos"], obstacles, task.obstacle_clearance)
    assert not (near & ~hits & (trace["step"] > 0)).any()
    assert near[hits].mean() > 0.7  # the others touched it on their way


def test_an_obstacle_on_the_way_is_touched(make):
    """Also where the arm is past it when the period ends."""
    env = make(1, ReachTask(horizon=60, obstacles="0.75x0x0.2x0.01", start_noise=0.0), seed=0)
    episodes, around = env.episodes, env._decisions.around
    episodes.extra("obstacles")[0, :3] = ROBOT.end_effector(episodes.qpos)[0]
    aside = np.array([0.6, 0.0, 0.0, 0.0, 0.0, 0.0])
    around._before[...], episodes.qpos[...] = episodes.qpos - aside, episodes.qpos + aside
    assert around.struck()[0]
    assert not around.struck()[0]


def test_the_learner_sees_the_obstacles(make):
    """Behind what it sees anyway, the nearest first, from the end effector."""
    env = make(2, ReachTask(obstacles=NEAR_HOME, obstacles_seen=3))
    seen, _ = env.reset(seed=0)
    assert seen.shape == (2, 3 * DOF + 10 + 21)
    first = seen[:, 3 * DOF + 10 : 3 * DOF + 17]
    assert_allclose(first[:, :3] + env.episodes.end_effector, [[0.9, 0.4, 0.6]] * 2, atol=1e-6)
    assert_allclose(first[:, 3:], [[0.05, 0.05, 0.15, 0.0]] * 2, atol=1e-7)
    assert not seen[:, -7:].any()


def test_arms_differ_and_are_told_nothing_of_it(make, wandered):
    """The end effector that is recorded is the arm's own; the one that is seen is the drawing's."""
    task = ReachTask(horizon=9, length_variation=0.1, variants=4)
    trace = wandered(task, 4)
    tip = np.stack([trace[f"end_effector_{axis}"] for axis in "xyz"], axis=1)
    assert set(trace["arm"]) == {0, 1, 2, 3}
    for arm in range(4):
        rows = trace["arm"] == arm
        own = draw_robot(task, ROBOT, arm).end_effector(trace["qpos"][rows])
        assert_allclose(tip[rows], own, atol=1e-12)
        assert np.abs(own - ROBOT.end_effector(trace["qpos"][rows])).max() > 0.005
    env = make(2, task)
    seen, _ = env.reset(seed=0)
    drawn = ArmObservation(ROBOT, 0.1)
    assert_allclose(seen[:, drawn.arm_columns[-3:]], ROBOT.end_effector(env.episodes.qpos), atol=1e-6)


def test_the_plain_task_leaves_no_more_columns(wandered):
    """Its traces stay as they were; nothing was touched in them."""
    trace = wandered(ReachTask(horizon=9))
    assert not {"arm", "obstacle", "obstacles"} & set(trace.columns)
    assert not trace["obstacle"].any()


def test_equal_episodes_have_their_obstacles_placed_once(make, monkeypatch):
    """Where each has them alone: to find a place takes 20 ms."""
    alone = make(1, WORSE)
    alone.reset(seed=[6])
    places = []
    draw = surroundings.draw_clutter
    monkeypatch.setattr(surroundings, "draw_clutter", lambda *given: places.append(draw(*given)) or places[-1])
    env = make(5, WORSE)
    env.reset(seed=[5, 6, 5, 6, 6])
    assert len(places) == 2
    assert_array_equal(env.episodes.extra("obstacles")[[1, 3, 4]], alone.episodes.extra("obstacles")[[0] * 3])
