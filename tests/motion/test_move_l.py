"""MoveL: the end effector goes straight, and the arm stays within its limits."""

import numpy as np
import pytest
from numpy.linalg import norm
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.robot import forward
from harness.task import build_motion
from tests.registered import UNITY_ARM

COUNT = 30
UCS = "ucs_origin=0.1x0x0,ucs_x=0.1x2x0,ucs_xy=0.1x1x1"
"""x is the world's y, y the world's z, z the world's x."""


def near_home(robot):
    """Poses, (COUNT, dof), around the home pose."""
    noise = default_rng(0).uniform(-0.15, 0.15, (COUNT, robot.dof))
    return np.clip(robot.home + noise * (robot.upper - robot.lower) / 2.0, robot.lower, robot.upper)


def drive_along(motion, robot, world, periods):
    """Where the end effector is at each waypoint, (count, n, 3), and whether it was held before, (count, n).

    `world` is the wanted direction, (n, 3); in the motion's axes it is found anew in every period.
    """
    qpos, qvel = near_home(robot), np.zeros((COUNT, robot.dof))
    tips, held = [robot.end_effector(qpos)], [np.zeros(COUNT, bool)]
    for _ in range(periods):
        axes = motion.axes.to_world(qpos, np.tile(np.eye(3), (COUNT, 1, 1)))
        move = motion.advance(qpos, qvel, np.vecdot(axes, world[:, None]))
        for waypoint in move.waypoints:
            tips.append(robot.end_effector(waypoint))
            held.append(held[-1] | move.held)
        qpos, qvel = move.waypoints[-1], move.qvel
    return np.array(tips), np.array(held)


@pytest.fixture(scope="module")
def driven(arm, setting_of, directions):
    """What `drive_along` gives for an arm that is told directions in the axes of the world."""
    return drive_along(build_motion("movel", setting_of(arm)), arm, directions(COUNT), 30)


def require_line(tips, held, world):
    """Within 1 mm while not held, and of some length."""
    way = tips - tips[0]
    assert np.where(held, 0.0, norm(way - np.vecdot(way, world)[..., None] * world, axis=-1)).max() < 1e-3
    assert norm(way, axis=-1).max() > 0.2


def test_the_end_effector_stays_on_the_line(driven, directions):
    """While it is not held it is within 1 mm of the line, on every arm, until it is at its limits."""
    require_line(*driven, directions(COUNT))


@pytest.mark.parametrize("frame", [f"ucs,{UCS}", "tcs"])
@pytest.mark.parametrize("arm", ["unity-arm", "elbow"], indirect=True)
def test_the_line_is_kept_in_any_frame(arm, setting_of, directions, frame):
    """Axes that the user gives, and the tool's, which turn as the arm moves."""
    motion, world = build_motion(f"movel:frame={frame}", setting_of(arm)), directions(COUNT)
    require_line(*drive_along(motion, arm, world, 30), world)


def test_the_check_on_the_line_sees_a_fault(fd100, setting_of, directions, monkeypatch):
    """Joint movements that are not solved to the end, only once, leave the line by more than a millimetre."""
    monkeypatch.setattr("harness.motion.tip.ITERATIONS", 0)
    world = directions(COUNT)
    tips, held = drive_along(build_motion("movel", setting_of(fd100)), fd100, world, 30)
    way = tips - tips[0]
    assert np.where(held, 0.0, norm(way - np.vecdot(way, world)[..., None] * world, axis=-1)).max() > 1e-3


def test_it_goes_the_way_it_is_told(driven, directions):
    """It does not go back on the line, but for the tenth of a millimetre that it comes too far where its reach ends."""
    tips, held = driven
    forward_steps = np.vecdot(np.diff(tips, axis=0), directions(COUNT))
    assert np.where(held[1:], 0.0, forward_steps).min() > -2e-4


def test_tip_speed_is_a_share_of_the_reach(fd100, setting_of):
    """0.5 m/s for the FD100, the number itself; for another arm as many of its lengths a second."""
    small = UNITY_ARM
    for mode in ("movel", "movea"):
        speeds = [build_motion(mode, setting_of(arm)).follower.tip_speed for arm in (fd100, small)]
        assert speeds == [0.5, small.scaled(0.5)]
        assert speeds[1] == pytest.approx(0.5 * small.reach / fd100.reach, rel=5e-3)


@pytest.mark.parametrize("parts", [1, 2, 4, 10])
def test_the_speed_becomes_tip_speed(fd100, setting_of, course_of, parts):
    """With a constant action the end effector gets to tip_speed, and no farther, into however many parts it is cut."""
    motion = build_motion(f"movel:tip_speed=0.3,parts={parts}", setting_of(fd100))
    course = course_of(motion, fd100.home[None], [np.array([[-0.6, 0.0, 0.8]])] * 6)
    speeds = norm(np.diff(fd100.end_effector(course.qpos[:, 0]), axis=0), axis=1) / (0.1 / parts)
    assert speeds[-1] == pytest.approx(0.3, rel=1e-3)
    assert speeds.max() < 0.3 * 1.001


def test_half_an_action_is_half_the_speed(fd100, setting_of, course_of):
    """The action is a fraction of tip_speed."""
    course = course_of(build_motion("movel", setting_of(fd100)), fd100.home[None], [np.array([[0.0, 0.5, 0.0]])] * 5)
    tips = fd100.end_effector(course.qpos[:, 0])
    assert_allclose(tips[-1] - tips[-5], [0.0, 0.025, 0.0], atol=1e-5)


def test_a_long_action_is_one_of_length_1(fd100, setting_of, course_of):
    """No direction is quicker than another: the corners of the action's box are not."""
    motion = build_motion("movel:tip_speed=0.2", setting_of(fd100))
    for action in ([1.0, 1.0, 1.0], [1e300, 1e300, np.inf]):
        course = course_of(motion, fd100.home[None], [np.array([action])] * 4)
        tips = fd100.end_effector(course.qpos[:, 0])
        assert norm(tips[-1] - tips[-5]) == pytest.approx(0.02, rel=1e-3)


@pytest.mark.parametrize(
    ("frame", "axis", "world"),
    [("wcs", 0, (1, 0, 0)), (f"ucs,{UCS}", 0, (0, 1, 0)), (f"ucs,{UCS}", 1, (0, 0, 1)), (f"ucs,{UCS}", 2, (1, 0, 0))],
)
def test_axes_of_the_action(fd100, setting_of, course_of, frame, axis, world):
    """A full action along an axis of the frame moves along that axis."""
    motion = build_motion(f"movel:frame={frame}", setting_of(fd100))
    course = course_of(motion, fd100.home[None], [np.eye(3)[axis][None]] * 2)
    way = np.diff(fd100.end_effector(course.qpos[[0, -1], 0]), axis=0)[0]
    assert_allclose(way / norm(way), world, atol=1e-3)


def test_tool_axis_of_the_action(fd100, setting_of, course_of):
    """In the TCS the action's z leads along the tool's, as it points at the start of the period."""
    course = course_of(build_motion("movel:frame=tcs", setting_of(fd100)), fd100.home[None], [np.array([[0, 0, 1.0]])])
    way = np.diff(fd100.end_effector(course.qpos[[0, -1], 0]), axis=0)[0]
    tool = forward(fd100.chain, fd100.home)[:3, 2]
    assert_allclose(way / norm(way), tool, atol=1e-3)


@pytest.mark.parametrize(
    "arm",
    ["fd100", "gantry", *(pytest.param(name, marks=pytest.mark.slow) for name in ("unity-arm", "scara", "elbow"))],
    indirect=True,
)
def test_out_of_reach_it_is_held_and_stands(arm, setting_of, course_of, directions):
    """Driven on in one direction every arm ends held, at rest, and it stays so."""
    course = course_of(build_motion("movel", setting_of(arm)), near_home(arm)[:12], [directions(12)] * 150)
    standing = np.abs(course.qpos[-40:] - course.qpos[-1]).max(axis=(0, 2)) < 1e-9
    assert standing.mean() > 0.97
    assert course.held[-10:, standing].all()


def test_acceleration_is_no_hold(fd100, setting_of, course_of, directions):
    """An arm that gathers speed in the middle of its reach is not held, though it does less than it is told."""
    motion = build_motion("movel", setting_of(fd100))
    assert not course_of(motion, np.tile(fd100.home, (COUNT, 1)), [directions(COUNT)] * 3).held.any()


def test_brakes_on_the_line(fd100, setting_of, course_of, directions):
    """Told to stay, the end effector goes on along its line until it stands."""
    motion, world = build_motion("movel", setting_of(fd100)), directions(COUNT)
    actions = [world] * 4 + [np.zeros_like(world)] * 4
    course = course_of(motion, np.tile(fd100.home, (COUNT, 1)), actions)
    way = fd100.end_effector(course.qpos) - fd100.end_effector(fd100.home)
    assert norm(way - np.vecdot(way, world)[..., None] * world, axis=-1).max() < 2e-3
    assert_array_equal(course.qvel[-1], 0.0)
    assert not course.held.any()


def test_an_arm_alone_does_what_it_does_among_others(fd100, setting_of, course_of, poses, directions):
    """Bit for bit, also where the others need more steps to be solved."""
    motion, start, action = build_motion("movel", setting_of(fd100)), poses(fd100, 8), directions(8)
    together = course_of(motion, start, [action] * 5).qpos
    for k in range(8):
        assert_array_equal(course_of(motion, start[k : k + 1], [action[k : k + 1]] * 5).qpos[:, 0], together[:, k])
