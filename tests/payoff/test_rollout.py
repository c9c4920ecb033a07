"""Recorded rollouts: the same episodes for all, and no reward in them."""

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from numpy.linalg import norm
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_equal

from harness import load_robot
from harness.env.vector_env import ReachVectorEnv
from harness.errors import UsageError
from harness.experiment.arm_evaluation import EVALUATION_SEED
from harness.payoff.rollout import (
    SCRIPTS,
    plan_actions,
    record_rollouts,
    score_rollout,
)
from harness.record.trace import TERM
from harness.registry import choose
from harness.reward.forms import reward_class
from harness.reward.steps import ARM_BEFORE
from harness.task import ReachTask
from harness_plugins.kit import IdealSimulator
from harness_plugins.tasks.moving import Moving
from harness_plugins.tasks.pose import Pose
from harness_plugins.tasks.unity import UnityReach as Unity
from tests.heavy_arms import Heavy
from tests.refusals import refused
from tests.registered import REGISTRY


def test_batches_do_the_same(robot, task):
    """A simulator of which three arms are held at once moves twelve to the same places, noise included."""
    both = (record_rollouts(simulator, robot, task, 12, 0.1) for simulator in (IdealSimulator(), Heavy()))
    for one, other in zip(*both, strict=True):
        assert_equal(vars(one), vars(other))


def test_all_scripts_are_recorded_in_order(rollouts):
    """One rollout of each."""
    assert tuple(rollout.script for rollout in rollouts) == SCRIPTS


def test_all_scripts_begin_alike(rollouts):
    """Episode k begins at the same distance under every script."""
    for rollout in rollouts:
        assert (rollout.distances[0] == rollouts[0].distances[0]).all()


def test_events_are_the_tasks(by_script, task):
    """An episode of finish is paid the steps' price and the target's reward, whatever the reward will be."""
    finish = by_script["finish"]
    assert finish.events.sum(axis=0) == pytest.approx(task.target_reward + finish.steps * task.step_reward)


def test_nothing_is_paid_after_the_end(by_script):
    """Where an episode is over, its events are 0."""
    finish = by_script["finish"]
    assert not finish.running.all()
    assert (finish.events[~finish.running] == 0.0).all()


def test_a_running_episode_was_never_over(rollouts):
    """`running` goes from True to False at most once."""
    for rollout in rollouts:
        assert rollout.running[0].all()
        assert (np.diff(rollout.running.astype(int), axis=0) <= 0).all()


def test_another_task_is_another_rollout(robot):
    """The task's epsilon is what finish ends at and hover keeps out of."""
    small = {
        rollout.script: rollout for rollout in record_rollouts(IdealSimulator(), robot, ReachTask(epsilon=0.01), 4)
    }
    assert small["hover"].distances[-1] == pytest.approx(0.012, abs=1e-5)
    assert small["finish"].reached.all()


def test_a_task_out_of_reach_is_a_usage_error(robot):
    """Nothing is recorded where the arm reaches no target."""
    with pytest.raises(UsageError):
        record_rollouts(IdealSimulator(), robot, ReachTask(target_center=(9.0, 0.0, 0.0)), 2)


@pytest.mark.parametrize("goal", [Pose(), Moving()])
def test_a_task_that_asks_for_more_is_a_usage_error(robot, goal):
    """The scripts go to points; it says which task to take instead."""
    with refused("fd100-reach"):
        record_rollouts(IdealSimulator(), robot, goal, 2)


def everything(step):
    """All fields, each in a term of its own; those of before too."""
    now = {name: _sum(getattr(step, name)) for name in ("step", "delta_distance", *ARM_BEFORE)}
    return now | {f"before-{name}": 3.0 * _sum(getattr(step.before, name)) for name in ARM_BEFORE}


def _sum(array):
    return 1.0 * array.reshape(len(array), -1).sum(-1)


@pytest.mark.parametrize("name", [*REGISTRY.names("rewards"), "everything"])
@pytest.mark.parametrize("script", ["creep", "oscillate", "random"])
def test_a_score_is_what_the_env_pays(robot, task, by_script, name, script):
    """Scoring a rollout afterwards gives what a learner would have been paid, for every reward and every field."""
    is_all = name == "everything"
    reward = reward_class(everything)() if is_all else choose(REGISTRY, "rewards", name).build(REGISTRY, "rewards")
    score = score_rollout(reward, by_script[script])
    env = ReachVectorEnv(IdealSimulator(), robot, task, reward, 12, autoreset_mode=AutoresetMode.DISABLED)
    env.reset(seed=EVALUATION_SEED)
    target = env.episodes.target.copy()
    rng = default_rng([EVALUATION_SEED, 2])
    actions = plan_actions(script, robot, task, env.simulation.read().qpos.copy(), target, rng)
    for step, running in enumerate(score.rollout.running):
        paid = env.step(actions[step])[1]
        assert score.paid[step][running] == pytest.approx(paid[running], rel=1e-12, abs=1e-12)
        for term, column in score.terms.items():
            assert (column[step] == env.episodes.extra(f"{TERM}{term}")[:, 0])[running].all()
    env.close()


@pytest.mark.parametrize("task", [ReachTask(horizon=40), Unity(action="movej", horizon=400)], ids=["fd100", "unity"])
def test_the_target_of_a_state_is_that_of_its_distance(task):
    """Also where a task sets the next one at the end of a step."""
    for rollout in record_rollouts(IdealSimulator(), load_robot(task.robot), task, 6):
        states = rollout.states
        assert_allclose(norm(states["target"] - states["end_effector"], axis=-1), states["distance"], atol=1e-12)
