"""Smooth motions: within every limit, clear of the ground, the same for the same seed."""

from dataclasses import replace

import numpy as np
import pytest

from harness.robot import build_solids, link_frames
from harness_plugins.parity.classes import class_motions
from harness_plugins.parity.motions import (
    GroundClearance,
    point_heights,
    smooth_motions,
)

PERIOD, CLEARANCE = 0.1, 0.1


def speeds(motion, period=PERIOD):
    """Joint speeds of each period, at rest before the first, [rad/s]."""
    return np.diff(motion, axis=0, prepend=motion[:1]) / period


@pytest.mark.parametrize(("steps", "period"), [(200, 0.1), (1000, 0.02), (1, 0.1), (2000, 0.1)])
def test_limits_are_kept(each_robot, steps, period):
    """Ranges, 80 % of the speeds and 60 % of the accelerations, from rest on."""
    motion = smooth_motions(each_robot, 0, 4, steps, period).motions
    assert motion.shape == (steps + 1, 4, each_robot.dof)
    assert (each_robot.lower <= motion).all()
    assert (motion <= each_robot.upper).all()
    speed = speeds(motion, period)
    assert (np.abs(speed) <= 0.8 * each_robot.max_speed * (1 + 1e-9)).all()
    change = np.abs(np.diff(speed, axis=0)) / period
    assert (change <= 0.6 * each_robot.max_acceleration * (1 + 1e-9)).all()


def test_every_joint_really_moves(each_robot):
    """In each motion a joint gets to a third of what it may at least; in the best of eight to nearly all of it."""
    share = np.abs(speeds(smooth_motions(each_robot, 0, 8, 200, PERIOD).motions)).max(axis=0) / (
        0.8 * each_robot.max_speed
    )
    assert share.min() > 1 / 3
    assert (share.max(axis=0) > 0.9).all()


def test_motions_stay_clear_of_the_ground(each_robot):
    """Joints and tip keep a tenth of the reach above it."""
    motion = smooth_motions(each_robot, 3, 8, 200, PERIOD).motions.reshape(-1, each_robot.dof)
    assert point_heights(each_robot, motion).min() >= CLEARANCE * each_robot.reach


def test_a_seed_gives_the_same_motions(robot):
    """Episode n is the same in every batch; another seed gives others."""
    few, many = smooth_motions(robot, 5, 2, 50, PERIOD).motions, smooth_motions(robot, 5, 4, 50, PERIOD).motions
    np.testing.assert_array_equal(few, many[:, :2])
    assert not np.isclose(many[0, 0], many[0, 1]).any()
    assert not np.isclose(few[0], smooth_motions(robot, 6, 2, 50, PERIOD).motions[0]).any()


def test_lowest_point_is_the_lowest_of_tip_and_joints(robot):
    """Stretched out straight up the second joint is lowest; head down the tip is."""
    folded = robot.home.copy()
    folded[1] = robot.upper[1]
    heights = point_heights(robot, np.stack([np.zeros(robot.dof), folded])).min(axis=0)
    assert 0.0 < heights[0] <= robot.end_effector(np.zeros(robot.dof))[2]
    assert heights[1] == pytest.approx(robot.end_effector(folded)[2])


def test_an_arm_whose_home_is_on_the_ground_is_moved_all_the_same(robot):
    """No motion from there keeps a tenth of the reach; solids stay above it, and it is told."""
    low = replace(robot, home=np.array([0.0, robot.upper[1], 0.0, 0.0, 0.0, 0.0]))
    drawn = smooth_motions(low, 0, 1, 20, PERIOD)
    assert drawn.held == "solids"
    assert np.ptp(drawn.motions, axis=0).min() > 0.01
    assert GroundClearance(low, "solids").is_clear(drawn.motions[:, 0]).all()
    assert not GroundClearance(low).is_clear(drawn.motions[:, 0]).all()


def test_solids_stay_above_the_ground(each_robot):
    """Each joint's solids keep 2 cm, or half of what they have at home, in every class but the dives."""
    ground = GroundClearance(each_robot)
    for motion in (
        smooth_motions(each_robot, 3, 4, 100, PERIOD).motions,
        *(drawn.motions for drawn in class_motions(each_robot, 3, 4, 100, PERIOD).values()),
    ):
        assert ground.is_clear(motion.reshape(-1, each_robot.dof)).all()


def test_a_long_tool_keeps_above_the_ground_that_tip_and_joints_are_far_from(robot):
    """A rod of 0.6 m beyond the tip: motions swing less far, and it stays above; the tip alone would not tell."""
    pose = np.eye(4)
    pose[0, 3] = 0.3
    rod = replace(robot.joint_shapes[-1][0], kind="box", size=(0.6, 0.02, 0.02), T_link_shape=pose)
    armed = replace(robot, joint_shapes=(*robot.joint_shapes[:-1], (*robot.joint_shapes[-1], rod)))
    motion = smooth_motions(armed, 0, 3, 100, PERIOD).motions.reshape(-1, robot.dof)
    assert build_solids(armed.joint_shapes).lowest(link_frames(armed.chain, motion)).min() > 0.019
    before = smooth_motions(robot, 0, 3, 100, PERIOD).motions.reshape(-1, robot.dof)
    assert build_solids(armed.joint_shapes).lowest(link_frames(armed.chain, before)).min() < 0.0


def test_a_joint_that_stands_still_near_the_ground_holds_nothing_up(robot):
    """As the second joint of a turret below a tenth of the reach, which cannot meet the ground: motions are drawn."""
    tall = replace(robot)
    tall.__dict__["reach"] = 1.05 * point_heights(robot, robot.home[None])[0, 0] / CLEARANCE
    motion = smooth_motions(tall, 0, 2, 20, PERIOD).motions.reshape(-1, robot.dof)
    assert point_heights(robot, motion)[1:].min() >= CLEARANCE * tall.reach
