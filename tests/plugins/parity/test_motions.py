"""What simulators are told: each class within its limits and clear of the ground, the same for the same seed."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.linalg import norm
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.robot import build_solids, link_frames
from harness_plugins.parity import Setting
from harness_plugins.parity.classes import draw_fast, draw_singular
from harness_plugins.parity.motions import GroundClearance, point_heights, smooth_motions
from harness_plugins.parity.orders import draw_orders

PERIOD, CLEARANCE, DEPTH = 0.1, 0.1, 0.1
LIMITS = {"slow": (0.2, 0.1), "smooth": (0.8, 0.6), "fast": (1.0, 1.0), "singular": (1.0, 1.0), "contact": (0.8, 0.6)}
"""Shares of the joints' largest speeds and accelerations, by class; contact is what dives are told."""


def shares_of(robot, motion, period=PERIOD):
    """Speeds and changes of speed of each period, from rest on, as shares of the joints' maxima."""
    speed = np.diff(motion, axis=0, prepend=motion[:1]) / period
    change = np.diff(speed, axis=0) / period
    return np.abs(speed) / robot.max_speed, np.abs(change) / robot.max_acceleration


def check_limits(robot, motion, period, name):
    """Ranges, speeds and accelerations."""
    assert (robot.lower <= motion).all(), name
    assert (motion <= robot.upper).all(), name
    for share, most in zip(shares_of(robot, motion, period), LIMITS[name], strict=True):
        assert (share <= most * (1 + 1e-9)).all(), name


@pytest.fixture(scope="module", params=[PERIOD, 0.02])
def period(request):
    """Of control."""
    return request.param


@pytest.fixture(scope="module")
def orders(each_robot, period):
    """Eight motions of each class, 60 control periods."""
    return draw_orders(Setting(each_robot, 60, 8, 0, period))


def test_limits_are_kept(orders, each_robot, period):
    """In every class; tip, joints and solids stay above the ground in all but the dives."""
    assert list(orders.classes) == list(LIMITS)
    ground = GroundClearance(each_robot)
    for name, motion in orders.classes.items():
        check_limits(each_robot, motion, period, name)
        if name != "contact":
            assert motion.shape == (61, 8, each_robot.dof)
            rows = motion.reshape(-1, each_robot.dof)
            assert point_heights(each_robot, rows).min() >= CLEARANCE * each_robot.reach - 1e-12, name
            assert ground.is_clear(rows).all(), name


@pytest.mark.parametrize(("steps", "period"), [(200, 0.1), (1000, 0.02), (1, 0.1), (2000, 0.1)])
def test_smooth_motions_may_be_of_any_length(each_robot, steps, period):
    """And keep the limits."""
    motion = smooth_motions(each_robot, 0, 4, steps, period).motions
    assert motion.shape == (steps + 1, 4, each_robot.dof)
    check_limits(each_robot, motion, period, "smooth")


def test_fast_is_at_the_limits(each_robot):
    """Fast joints have their largest speed most of the time, and turn at their largest acceleration."""
    speed, change = shares_of(each_robot, draw_orders(Setting(each_robot, 60, 2)).classes["fast"])
    assert (speed.max(), change.max()) == (pytest.approx(1.0), pytest.approx(1.0))
    assert np.mean(speed[1:] > 0.99) > 0.2


def test_singular_motions_stay_near_a_singular_pose(orders, each_robot):
    """Its smallest singular value is far below that of home."""
    motion = orders.classes["singular"]
    assert np.abs(motion - motion[0]).max() <= 0.15 + 1e-9
    home = np.linalg.svd(each_robot.jacobian(each_robot.home), compute_uv=False)[-1]
    values = np.linalg.svd(each_robot.jacobian(motion[0]), compute_uv=False)[:, -1]
    assert (values < 0.02 * each_robot.reach).all()
    assert (values < home).all()


def test_dives_end_below_the_ground(orders, each_robot):
    """Each starts above and ends `DEPTH` below, in another place than the others."""
    assert (each_robot.end_effector(orders.dives[0])[:, 2] > 0.2).all()
    ends = each_robot.end_effector(orders.dives[-1])
    assert_allclose(ends[:, 2], -DEPTH, atol=2e-3)
    assert norm(ends[:, None] - ends, axis=-1)[~np.eye(8, dtype=bool)].min() > 0.01


def test_a_seed_gives_the_same_motions(robot):
    """Motion n is the same in every batch, but for a dive's wait for the slowest; another seed gives others."""
    few, many, other = (draw_orders(Setting(robot, 12, *drawn)).classes for drawn in ((2, 5), (4, 5), (2, 6)))
    for name, motion in few.items():
        rows = min(len(motion), len(many[name]))
        assert_array_equal(motion[:rows], many[name][:rows, :2])
        assert not np.isclose(motion[-1], other[name][-1]).all()
    assert not np.isclose(many["smooth"][0, 0], many["smooth"][0, 1]).any()
    assert not np.isclose(few["smooth"][0], other["smooth"][0]).any()


def test_poses_cover_the_ranges(robot):
    """At least so many, uniform, the same for the same seed."""
    poses, again = (draw_orders(Setting(robot, 1, 7)).poses for _ in range(2))
    assert poses.shape[1:] == (7, robot.dof)
    assert 64 <= poses.shape[0] * 7 < 64 + 7
    share = (poses - robot.lower) / (robot.upper - robot.lower)
    assert (share >= 0.0).all()
    assert (share <= 1.0).all()
    assert (share.min(axis=(0, 1)) < 0.1).all()
    assert (share.max(axis=(0, 1)) > 0.9).all()
    assert_array_equal(poses, again)


def test_every_joint_really_moves(each_robot):
    """In each motion a joint gets to a third of what it may at least; in the best of eight to nearly all of it."""
    speed, _ = shares_of(each_robot, smooth_motions(each_robot, 0, 8, 200, PERIOD).motions)
    share = speed.max(axis=0) / 0.8
    assert share.min() > 1 / 3
    assert (share.max(axis=0) > 0.9).all()


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


def with_rod(robot, length):
    """A robot with a tool along the last link, half of it beyond the tip."""
    pose = np.eye(4)
    pose[0, 3] = length / 2
    rod = replace(robot.joint_shapes[-1][0], kind="box", size=(length, 0.02, 0.02), T_link_shape=pose)
    return replace(robot, joint_shapes=(*robot.joint_shapes[:-1], (*robot.joint_shapes[-1], rod)))


def test_a_long_tool_keeps_above_the_ground_that_tip_and_joints_are_far_from(robot):
    """A rod of 0.6 m beyond the tip: motions swing less far, and it stays above; the tip alone would not tell."""
    armed = with_rod(robot, 0.6)
    after, before = (
        build_solids(armed.joint_shapes).lowest(
            link_frames(armed.chain, smooth_motions(arm, 0, 3, 100, PERIOD).motions.reshape(-1, robot.dof))
        )
        for arm in (armed, robot)
    )
    assert after.min() > 0.019
    assert before.min() < 0.0


def test_an_arm_whose_tip_gets_nowhere_dives_with_a_solid(robot):
    """Its tip cannot get below the ground, and a long tool can."""
    lower, upper = np.maximum(robot.lower, robot.home - 0.5), np.minimum(robot.upper, robot.home + 0.5)
    short = replace(robot, lower=lower, upper=upper)
    armed = with_rod(short, 1.4)
    without, dives = (draw_orders(Setting(arm, 1, 2)).dives for arm in (short, armed))
    assert without is None
    above, below = (build_solids(armed.joint_shapes).lowest(link_frames(armed.chain, dives[row])) for row in (0, -1))
    assert (below < -DEPTH).all()
    assert (above > below).all()


def with_reach(robot, reach):
    """A robot that takes itself for larger, so that it keeps farther from the ground."""
    larger = replace(robot)
    larger.__dict__["reach"] = reach
    return larger


def test_a_joint_that_stands_still_near_the_ground_holds_nothing_up(robot):
    """As the second joint of a turret below a tenth of the reach, which cannot meet the ground: motions are drawn."""
    tall = with_reach(robot, 1.05 * point_heights(robot, robot.home[None])[0, 0] / CLEARANCE)
    motion = smooth_motions(tall, 0, 2, 20, PERIOD).motions.reshape(-1, robot.dof)
    assert point_heights(robot, motion)[1:].min() >= CLEARANCE * tall.reach


def test_a_fast_motion_that_cannot_go_on_stops(robot):
    """An arm whose every way leads to the ground brakes, and stays where it is."""
    low = point_heights(robot, robot.home[None])[1:].min() / CLEARANCE  # all but the second joint, which stands still
    larger = with_reach(robot, 1.5 * low)
    motion = draw_fast(larger, default_rng(0), 30, PERIOD, GroundClearance(larger))
    assert_array_equal(motion[1:], np.tile(motion[0], (30, 1)))


def test_near_the_ground_there_is_no_singular_motion(robot):
    """None, not one that meets it."""
    larger = with_reach(robot, 100.0)
    assert draw_singular(larger, default_rng(0), 5, PERIOD, GroundClearance(larger)) is None
