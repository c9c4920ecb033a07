"""A task that asks for more than a point that stays, in the env and in its record."""

import numpy as np
import pytest
from numpy.linalg import norm
from numpy.testing import assert_allclose, assert_array_equal
from pydantic.dataclasses import dataclass

from harness import make_env
from harness.score.scorer import pay_log
from harness.task import Goal, ReachTask, goal_of
from harness_plugins.tasks.moving import Moving
from harness_plugins.tasks.pose import Pose
from tests.env.conftest import REGISTRY, build
from tests.refusals import refused
from tests.registered import FD100 as ROBOT


class Distance(Goal):
    """Asks for what `fd100-reach` asks for."""

    error = "distance"

    def errors(self, now):
        """From end effector to target, as the env measures it without a goal, [m]."""
        offset = now.target - now.end_effector
        return np.asarray(np.sqrt(np.vecdot(offset, offset)))


@dataclass(frozen=True)
class SameReach(ReachTask):
    """`fd100-reach`, told as a goal."""

    def goal(self, robot):
        """See `harness.task.Task`."""
        return Distance()


@dataclass(frozen=True)
class NextPoses(Pose):
    """The episode goes on with the next pose."""

    ends_at_target = False


def test_distance_as_a_goal_leaves_the_same_trace(make, wander, recorded, tmp_path):
    """Bit for bit: a task without a goal is a task whose error is the distance."""
    files = []
    for task in (ReachTask, SameReach):
        trace = recorded(make(3, task(horizon=15, epsilon=0.2)), lambda env: wander(env, 60))
        files.append((tmp_path / "trace.parquet").read_bytes())
    assert files[0] == files[1]
    assert trace["reached"].any()


def test_task_without_a_goal_measures_the_length_of_the_offset(make, wander):
    """To the last bit."""
    env = make(3, seed=0)
    for _ in wander(env, 10):
        offset = env.episodes.offset
        assert_array_equal(env.episodes.distance, np.sqrt(np.vecdot(offset, offset)))
    assert goal_of(env.task, env.robot) is None


def test_target_is_recorded_where_it_is(make, wander, recorded):
    """In each row; and the distance is that to it."""
    trace = recorded(make(3, Moving(horizon=12, target_speed=0.2)), lambda env: wander(env, 60))
    target, tip = (np.stack([trace[f"{name}_{axis}"] for axis in "xyz"], 1) for name in ("target", "end_effector"))
    assert_allclose(trace["distance"], norm(target - tip, axis=1), rtol=1e-12)
    for rows in trace.episodes:
        ways = norm(np.diff(target[rows], axis=0), axis=1)
        assert (ways <= 0.02 + 1e-9).all()
        assert np.median(ways) == pytest.approx(0.02)


@pytest.mark.parametrize("task", [Moving(horizon=12), Pose(horizon=12), NextPoses(horizon=30, epsilon=0.3, angle=3.0)])
@pytest.mark.parametrize("reward", REGISTRY.names("rewards"))
def test_every_reward_pays_the_record_again(make, wander, recorded, task, reward):
    """Exactly as it was paid, whatever the error is."""
    built = build("rewards", reward)
    trace = recorded(make(2, task, reward=built), lambda env: wander(env, 40))
    assert_array_equal(pay_log(built, trace).total, trace["reward"])


@pytest.mark.parametrize("task", [Moving(horizon=12), Pose(horizon=12)])
def test_episodes_are_those_of_the_seed(make, wander, task):
    """Env k meets the same goals whatever the number of envs and the actions."""
    one, other = make(1, task), make(3, task)
    for env in (one, other):
        env.reset(seed=4)
    wander(one, 25, seed=1)
    wander(other, 25, seed=2)
    assert_array_equal(one.episodes.numbers[0], other.episodes.numbers[0])
    assert one.episodes.numbers.any()


def test_learner_sees_the_error_and_the_goal(make):
    """After the numbers of `fd100-reach`, with the error in place of the distance."""
    env = make(2, Pose())
    seen, infos = env.reset(seed=0)
    assert seen.shape == (2, 28 + 9)
    assert_allclose(seen[:, 27], infos["distance"], rtol=1e-6)
    assert_allclose(seen[:, 28:], env.episodes.goal.observe(env.episodes.situation), atol=1e-6)


def test_epsilon_that_covers_all_errors_is_refused():
    """By `check`, before anything is planned."""
    with refused("epsilon=9"):
        SameReach(epsilon=9.0).check(ROBOT)


def test_tasks_take_another_robot(subtests):
    """Scaled by its reach."""
    for task in ["fd100-pose", "fd100-moving", "fd100-small-target", "fd100-low"]:
        for robot in ["fd100", "unity-arm"]:
            with subtests.test(task=task, robot=robot):
                env = make_env("kinematic", task, "dense", robot, num_envs=2)
                env.reset(seed=0)
                _, rewards, _, _, infos = env.step(env.action_space.sample() * 0.0)
                env.close()
                assert np.isfinite(rewards).all()
                assert (infos["distance"] > 0.0).all()


def test_conditions_and_goals_go_together(make, wander):
    """What is seen with noise has the error of what is seen; the goal's numbers stand before the obstacles'."""
    task = Pose(horizon=12, joint_noise=0.02, obstacle_count=1)
    env = make(2, task, seed=0)
    seen = wander(env, 3)[-1][0]
    assert seen.shape[1] == len(task.observation(ROBOT).low) > 28 + 9
    assert not np.allclose(seen[:, 27], env.episodes.distance, atol=1e-6)
    assert_allclose(seen[:, 28:34], env.episodes.numbers, atol=1e-6)
