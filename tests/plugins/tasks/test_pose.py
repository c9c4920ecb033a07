"""The task with an orientation: its error, its targets, and who can do it."""

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.linalg import norm
from numpy.random import default_rng
from numpy.testing import assert_array_equal

from harness.robot import forward
from harness.robot.kinematics import rotation_between
from harness.task import Situation
from harness_plugins.tasks.pose import Pose
from tests.registered import FD100 as ROBOT

POSES = st.lists(st.floats(0.0, 1.0), min_size=ROBOT.dof, max_size=ROBOT.dof).map(
    lambda share: (ROBOT.lower + np.array(share) * (ROBOT.upper - ROBOT.lower))[None]
)
"""Joint positions, (1, dof)."""


def goal(task=Pose()):  # noqa: B008 (frozen)
    """Of the task."""
    return task.goal(ROBOT)


def asked_for(at, target):
    """An arm with the joints `at`, asked for the pose that it has with the joints `target`."""
    pose = forward(ROBOT.chain, target)
    none = np.zeros(1)
    axes = np.concatenate([pose[:, :3, 0], pose[:, :3, 1]], axis=1)
    return Situation(at, ROBOT.end_effector(at), pose[:, :3, 3], axes, none, none)


def error(at, target):
    """Of that arm, [m]."""
    return float(goal().errors(asked_for(at, target))[0])


@settings(max_examples=30)
@given(POSES)
def test_error_is_0_in_the_pose(qpos):
    """Up to rounding, whatever the pose."""
    assert error(qpos, qpos) <= 1e-7


@settings(max_examples=30)
@given(POSES, POSES)
def test_error_is_the_same_both_ways(one, other):
    """Distance and angle are."""
    assert error(one, other) == pytest.approx(error(other, one), abs=1e-6)


@settings(max_examples=30)
@given(POSES, POSES)
def test_within_epsilon_means_near_and_turned_alike(at, target):
    """The error is at most epsilon where the distance is and the angle is at most 10 degrees; and nowhere else."""
    task, (one, other) = Pose(), (forward(ROBOT.chain, qpos) for qpos in (at, target))
    distance = norm(one[0, :3, 3] - other[0, :3, 3])
    angle = norm(rotation_between(one[:, :3, :3], other[:, :3, :3]))
    for epsilon in (0.02, 0.2, 2.0):  # the same question on a coarser scale: random poses are seldom within 2 cm
        wide = Pose(epsilon=epsilon, angle=min(math.pi, task.angle * epsilon / task.epsilon))
        assert (goal(wide).errors(asked_for(at, target))[0] <= epsilon) == (distance <= epsilon and angle <= wide.angle)


def test_turn_of_the_flange_alone_is_an_error():
    """At the target, with the last joint turned by 20 degrees: twice the tolerance."""
    turned = ROBOT.home[None].copy()
    turned[0, -1] += math.radians(20)
    assert np.allclose(ROBOT.end_effector(turned), ROBOT.end_effector(ROBOT.home[None]))
    assert error(turned, ROBOT.home[None]) == pytest.approx(0.04)


def test_orientations_differ_and_can_be_taken():
    """Of 100 targets no two orientations are alike; without a turn they are those of the usual poses."""
    rng = default_rng(0)
    position = Pose().draw_targets(ROBOT, rng, 100).position
    assert len(np.unique(goal().draw(rng, position).round(6), axis=0)) == 100
    assert_array_equal(goal(Pose(turn=0.0)).draw(rng, position), goal(Pose(turn=0.0)).draw(default_rng(7), position))


def test_turn_that_is_left_is_seen():
    """The last three numbers, over pi; the first six are the target's axes."""
    turned = ROBOT.home[None].copy()
    turned[0, -1] += math.radians(90)
    now = asked_for(turned, ROBOT.home[None])
    seen = goal().observe(now)
    assert_array_equal(seen[:, :6], now.numbers)
    assert norm(seen[0, 6:]) == pytest.approx(0.5)
