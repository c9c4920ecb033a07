"""Scripted policies: where they go, and that they keep within the arm's limits."""

import numpy as np
import pytest
from numpy.random import default_rng

from harness.payoff.rollout import SCRIPTS, plan_actions, record_rollouts
from harness.task import ReachTask
from harness_plugins.kit import IdealSimulator

MOVING = [script for script in SCRIPTS if script != "random"]


def draw(robot, task, count=200):
    """Starts and targets of `count` episodes."""
    rng = default_rng(1)
    return np.stack([task.draw_start(robot, rng) for _ in range(count)]), task.draw_targets(robot, rng, count).position


@pytest.fixture(scope="module")
def many(robot, task):
    """Rollouts of 200 episodes, by name."""
    return {rollout.script: rollout for rollout in record_rollouts(IdealSimulator(), robot, task, 200)}


@pytest.fixture(scope="module")
def from_afar(many, task):
    """Distances of the episodes that begin outside all rings, (steps + 1, n), by name."""
    afar = many["hold"].distances[0] > 2.4 * task.epsilon
    assert afar.sum() > 150
    return {script: rollout.distances[:, afar] for script, rollout in many.items()}


def test_finish_always_arrives(many):
    """Going straight to the target ends every episode there."""
    assert many["finish"].reached.all()


def test_finish_wastes_no_time(many, task):
    """It is at the target long before the horizon."""
    assert many["finish"].steps.max() < task.horizon / 5


@pytest.mark.parametrize("script", ["hover", "creep", "oscillate", "hold"])
def test_whoever_should_stay_outside_does(many, script):
    """No episode of a script that does not finish ends before the horizon, at the target or on the ground."""
    assert (many[script].steps == 100).all()
    assert not many[script].reached.any()


def test_hover_stands_just_outside_epsilon(from_afar, task):
    """After the approach the distance is 1.2 epsilon and does not change at all."""
    resting = from_afar["hover"][30:]
    assert resting == pytest.approx(1.2 * task.epsilon, abs=1e-5)
    assert (resting == resting[0]).all()


def test_hover_never_comes_nearer_than_where_it_stays(from_afar, task):
    """It stops without overshooting."""
    assert from_afar["hover"].min() > 1.2 * task.epsilon - 1e-5


def test_creep_comes_nearer_at_every_step_and_never_arrives(from_afar, task):
    """Its distance falls strictly from 1.2 epsilon on, and stays above 1.1 epsilon."""
    creeping = from_afar["creep"][30:]
    assert (np.diff(creeping, axis=0) < 0.0).all()
    assert creeping.min() > 1.1 * task.epsilon - 1e-5


def test_oscillate_swings_between_two_distances(from_afar, task):
    """It comes to 1.2 epsilon and goes back to 2.4 epsilon, time and again."""
    swinging = from_afar["oscillate"][30:]
    assert swinging.min(axis=0) == pytest.approx(1.2 * task.epsilon, abs=1e-5)
    assert swinging.max(axis=0) == pytest.approx(2.4 * task.epsilon, abs=1e-5)
    turns = np.diff(np.sign(np.diff(swinging, axis=0)), axis=0) != 0
    assert turns.sum(axis=0).min() > 10


def test_hold_does_not_move(many):
    """Its distance is the begin distance throughout."""
    assert (many["hold"].distances == many["hold"].distances[0]).all()


@pytest.mark.parametrize("script", SCRIPTS)
def test_actions_are_fractions_of_the_limits(robot, task, script):
    """No action asks for more than a joint's speed."""
    actions = plan_actions(script, robot, task, *draw(robot, task, 20), default_rng(0))
    assert actions.shape == (task.horizon, 20, robot.dof)
    assert np.abs(actions).max() <= 1.0


@pytest.mark.parametrize("script", MOVING)
def test_the_limits_on_acceleration_change_nothing(robot, task, script):
    """What a script asks for is what MoveJ does: its own limits are the stricter ones."""
    start, target = draw(robot, task, 20)
    motion = task.motion(robot)
    qpos, qvel = start, np.zeros_like(start)
    for action in plan_actions(script, robot, task, start, target, default_rng(0)):
        move = motion.advance(qpos, qvel, action.astype(np.float64))
        qpos, qvel = move.waypoints[-1], move.qvel
        assert qvel == pytest.approx(action * motion.limits.max_speed, abs=1e-5)


def test_a_start_within_the_ring_stays_there(robot, task):
    """Hovering from nearer than 1.2 epsilon is holding still."""
    start, _ = draw(robot, task, 5)
    target = robot.end_effector(start) + np.array([1.1 * task.epsilon, 0.0, 0.0])
    assert not plan_actions("hover", robot, task, start, target, default_rng(0)).any()


def test_one_step_is_enough_of_an_episode(robot):
    """A horizon of 1 gives rollouts of one step."""
    short = record_rollouts(IdealSimulator(), robot, ReachTask(horizon=1), 3)
    assert {len(rollout.distances) for rollout in short} == {2}
