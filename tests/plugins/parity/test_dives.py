"""Dives: within the limits, from near home to below the ground."""

from dataclasses import replace

import numpy as np
import pytest

from harness.robot import build_solids, link_frames
from harness_plugins.parity.orders import dive_motions

DEPTH = 0.1


@pytest.mark.parametrize("period", [0.1, 0.02])
def test_dives_end_below_the_ground(each_robot, period):
    """Each starts above and ends `DEPTH` below, in another place than the others."""
    dives = dive_motions(each_robot, 0, 8, period)
    assert (each_robot.end_effector(dives[0])[:, 2] > 0.2).all()
    ends = each_robot.end_effector(dives[-1])
    np.testing.assert_allclose(ends[:, 2], -DEPTH, atol=2e-3)
    assert np.linalg.norm(ends[:, None] - ends, axis=-1)[~np.eye(8, dtype=bool)].min() > 0.01


@pytest.mark.parametrize("period", [0.1, 0.02])
def test_limits_are_kept(each_robot, period):
    """Ranges, speeds and accelerations, from rest on."""
    dives = dive_motions(each_robot, 0, 8, period)
    speed = np.diff(dives, axis=0, prepend=dives[:1]) / period
    assert (each_robot.lower <= dives).all()
    assert (dives <= each_robot.upper).all()
    assert (np.abs(speed) <= 0.8 * each_robot.max_speed * (1 + 1e-9)).all()
    change = np.abs(np.diff(speed, axis=0)) / period
    assert (change <= 0.6 * each_robot.max_acceleration * (1 + 1e-9)).all()


def test_a_seed_gives_the_same_dives(robot):
    """Dive n is the same in every batch, but for the wait for the slowest."""
    few, many = dive_motions(robot, 5, 2, 0.1), dive_motions(robot, 5, 4, 0.1)
    rows = min(len(few), len(many))
    np.testing.assert_array_equal(few[:rows], many[:rows, :2])


def test_an_arm_that_cannot_reach_the_ground_has_no_dives(robot):
    """Said by None, not by motions that end in the air."""
    stiff = replace(robot, lower=robot.home - 0.05, upper=robot.home + 0.05)
    assert dive_motions(stiff, 0, 2, 0.1) is None


def test_an_arm_whose_tip_gets_nowhere_dives_with_a_solid(robot):
    """Its tip cannot get below the ground, and a long tool can."""
    pose = np.eye(4)
    pose[0, 3] = 0.7
    rod = replace(robot.joint_shapes[-1][0], kind="box", size=(1.4, 0.02, 0.02), T_link_shape=pose)
    lower, upper = np.maximum(robot.lower, robot.home - 0.5), np.minimum(robot.upper, robot.home + 0.5)
    short = replace(robot, lower=lower, upper=upper)
    assert dive_motions(short, 0, 2, 0.1) is None
    armed = replace(short, joint_shapes=(*robot.joint_shapes[:-1], (*robot.joint_shapes[-1], rod)))
    dives = dive_motions(armed, 0, 2, 0.1)
    heights = [build_solids(armed.joint_shapes).lowest(link_frames(armed.chain, row)) for row in (dives[0], dives[-1])]
    assert (heights[1] < -DEPTH).all()
    assert (heights[0] > heights[1]).all()
