"""The reach task: where episodes start, what the targets are, which overrides are refused."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.linalg import norm
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal, assert_array_less
from scipy.spatial.transform import Rotation

import harness
from harness.env.reach_task import FD100_CENTER, FD100_HALF_EXTENT, FD100_MOUNT, way_to_mount
from harness.robot import reach_position
from harness.robot.robot import read_robot
from harness.task import ReachTask, place_box
from tests.refusals import refused
from tests.registered import FD100 as ROBOT, UNITY_ARM
from tests.robot.brought_arms import TABLE_MOUNT, changed, read_arm


def rng():
    """The same numbers every time."""
    return default_rng(5)


def positions(task, count):
    """Targets of the FD100, (count, 3)."""
    return task.draw_targets(ROBOT, rng(), count).position


def test_targets_are_in_the_box():
    """Every target is within the half extent of the box's centre, and the box is used up to its faces."""
    task = ReachTask(target_center=(0.85, 0.0, 0.7), target_half_extent=(0.2, 0.3, 0.3))
    offset = np.abs(positions(task, 500) - task.target_center)
    assert (offset <= task.target_half_extent).all()
    assert (offset.max(axis=0) > 0.95 * np.array(task.target_half_extent)).all()


def test_box_of_the_fd100():
    """By default the centre is 0.85 m before the arm and 0.7 m high, and the box 0.4 x 0.6 x 0.6 m large."""
    center, half = ReachTask().target_box(ROBOT)
    assert_allclose(center, [0.85, 0.0, 0.7], rtol=1e-12)
    assert_allclose(half, [0.2, 0.3, 0.3], rtol=1e-12)


def test_box_of_another_arm_is_scaled_by_its_reach():
    """An arm of half the reach has a box of half the size at half the distance; one that is given stays as it is."""
    scale = UNITY_ARM.reach / ROBOT.reach
    for part, of_fd100 in zip(ReachTask().target_box(UNITY_ARM), ReachTask().target_box(ROBOT), strict=True):
        assert_allclose(part, scale * of_fd100, rtol=1e-12)
    given = ReachTask(target_center=(0.5, 0.1, 0.6), target_half_extent=(0.1, 0.2, 0.0))
    assert_array_equal(given.target_box(UNITY_ARM), [(0.5, 0.1, 0.6), (0.1, 0.2, 0.0)])


def test_box_of_the_fd100_is_the_same_bit_for_bit():
    """Whatever follows a mount, its own does not: neither that of the unity-arm."""
    for name in ("fd100", "unity-arm"):
        assert way_to_mount(harness.load_robot(name)).tolist() == [0.0, 0.0, 0.0]
    assert_array_equal(ReachTask().target_box(ROBOT), [(0.85, 0.0, 0.7), (0.2, 0.3, 0.3)])


def test_box_follows_a_mount_on_a_table(tmp_path):
    """It stands as high over a table as another one over the ground, and the arm reaches as much of it."""
    arms = [
        read_arm(tmp_path / name, changed(('xyz="0 0 0.1" rpy', f'xyz="0 0 {height}" rpy')))
        for name, height in {"table": 0.8, "stand": 0.2}.items()
    ]
    (center, half), (low, same_half) = map(ReachTask().target_box, arms)
    assert_array_equal(half, same_half)
    room = FD100_MOUNT * arms[0].reach / ROBOT.reach
    assert_allclose(center - low, [0.0, 0.0, 0.8 - room], atol=1e-12)
    assert center[2] - half[2] > 0.75
    points = default_rng(0).uniform(-1.0, 1.0, (64, 3)) * half
    reached = [
        reach_position(arm, points + box + [0.0, 0.0, shift], np.tile(arm.home, (64, 1)))[1]
        for arm, box, shift in zip(arms, (center, low), (0.0, 0.2 - room), strict=True)
    ]
    assert reached[0].sum() > 32
    assert_array_equal(*reached)


def test_box_follows_a_mount_beside_the_origin(tmp_path):
    """Two metres aside the arm would reach no target; a little aside it reaches all, and the box stays."""
    aside = read_arm(tmp_path / "a", changed(('xyz="0 0 0.1" rpy', 'xyz="-1.2 1.6 0.1" rpy')))
    near = read_arm(tmp_path / "b", changed(('xyz="0 0 0.1" rpy', 'xyz="-0.06 0.08 0.1" rpy')))
    room = FD100_MOUNT * aside.reach / ROBOT.reach
    assert_allclose(way_to_mount(aside), (2.0 - room) / 2.0 * np.array([-1.2, 1.6, 0.0]))
    assert not way_to_mount(near).any()
    ReachTask().check(aside)


def on_mount(arm, mount):
    """The arm, mounted otherwise."""
    joints = arm.chain.T_previous_joint.copy()
    joints[0] = mount @ joints[0]
    return replace(arm, chain=replace(arm.chain, T_previous_joint=joints, T_world_mount=mount.round(12)))


def pose(rotation, *xyz):
    """T_world_mount."""
    mount = np.eye(4)
    mount[:3, :3], mount[:3, 3] = rotation.as_matrix(), xyz
    return mount


def test_box_on_a_wall_and_under_a_ceiling_is_the_one_of_the_floor(subtests):
    """Turned with the mount, and reached as well: by a search for every point, and by the tips of random poses."""
    center, half = ReachTask().target_box(ROBOT)
    points = default_rng(0).uniform(-1.0, 1.0, (64, 3)) * half + center
    for name, turn in {"wall": ("y", 90), "other wall": ("x", -90), "ceiling": ("x", 180), "aside": ("z", 90)}.items():
        with subtests.test(name):
            mount = pose(Rotation.from_euler(*turn, degrees=True), 0.3, -2.0, 3.0)
            arm = on_mount(ROBOT, mount)
            moved, turned_half = ReachTask().target_box(arm)
            assert_allclose(moved, mount[:3, :3] @ center + mount[:3, 3], atol=1e-12)
            assert_allclose(turned_half, np.abs(mount[:3, :3]) @ half, atol=1e-12)
            assert reach_position(arm, points @ mount[:3, :3].T + mount[:3, 3], np.tile(arm.home, (64, 1)))[1].all()
            tips = arm.end_effector(default_rng(1).uniform(arm.lower, arm.upper, (20_000, 6)))
            assert (np.abs(tips - moved) <= turned_half).all(axis=1).sum() > 50


@given(rotvec=st.tuples(*[st.floats(-3.0, 3.0)] * 3), xyz=st.tuples(*[st.floats(-5.0, 5.0)] * 2, st.floats(4.0, 9.0)))
def test_box_follows_any_mount(rotvec, xyz):
    """Far above the ground its centre stands in the mount's frame where it stands in the world on the floor."""
    mount = pose(Rotation.from_rotvec(rotvec), *xyz)
    center, half = ReachTask().target_box(ROBOT)
    moved, around = ReachTask().target_box(on_mount(ROBOT, mount))
    assert_allclose(mount[:3, :3].T @ (moved - mount[:3, 3]), center, atol=1e-9)
    corners = np.array(list(itertools.product((-1, 1), repeat=3))) * half
    assert_allclose(np.abs(corners @ mount[:3, :3].T).max(axis=0), around, atol=1e-9)


TELESCOPE = [
    '<joint name="lift" type="prismatic"><parent link="base"/><child link="l1"/><origin xyz="0 0 0.2"/>'
    '<axis xyz="0 0 1"/><limit lower="0" upper="1.1" velocity="0.2" effort="1"/></joint>',
    '<joint name="arm" type="prismatic"><parent link="l1"/><child link="l2"/><origin xyz="0 -0.2 0"/>'
    '<axis xyz="0 -1 0"/><limit lower="0" upper="0.5" velocity="0.2" effort="1"/></joint>',
    '<joint name="wrist" type="revolute"><parent link="l2"/><child link="tip"/><axis xyz="0 0 1"/>'
    '<limit lower="-1.5" upper="3" velocity="2" effort="1"/></joint>',
    '<joint name="tool" type="fixed"><parent link="tip"/><child link="grasp"/><origin xyz="0 -0.2 0"/></joint>',
]
"""A mast that an arm rises on, which slides out to its side, as of a robot that drives."""


def test_an_arm_that_cannot_reach_the_box_has_one_of_its_own(tmp_path):
    """Its reach is mostly the mast: a box scaled by it lies where it cannot be. Its own lies around its home."""
    links = "".join(f'<link name="{name}"/>' for name in ("base", "l1", "l2", "tip", "grasp"))
    (tmp_path / "arm.urdf").write_text(f'<robot name="a">{links}{"".join(TELESCOPE)}</robot>')
    arm = read_robot(tmp_path / "arm.urdf")
    draw, half_edges = default_rng(1), ReachTask().target_box(arm)[1]
    shares = []
    for center, half in (place_box(arm, FD100_CENTER, FD100_HALF_EXTENT), ReachTask().target_box(arm)):
        points = center + draw.uniform(-1.0, 1.0, (200, 3)) * half
        shares.append(reach_position(arm, points, np.tile(arm.home, (200, 1)))[1].mean())
    assert shares[0] < 0.3
    assert shares[1] > 0.8
    assert half_edges.max() > 0.05 * arm.reach


def test_box_is_above_the_ground():
    """Before a wall that the arm hangs on half a metre high, the box would be in the ground."""
    mount = pose(Rotation.from_euler("y", 90, degrees=True), 0.0, 0.0, 0.5)
    center, half = ReachTask().target_box(on_mount(ROBOT, mount))
    assert center[2] - half[2] == pytest.approx(0.05 * ROBOT.reach)


def test_box_is_on_the_side_where_the_arm_is_at_home():
    """At +x up to 45 degrees beside it; an arm whose first joint rests at 90 degrees has it at +y."""
    center, half = ReachTask().target_box(ROBOT)
    for degrees, quarter in ((44, 0), (46, 1), (-90, -1), (170, 2)):
        home = ROBOT.home.copy()
        home[0] = math.radians(degrees)
        turn = Rotation.from_euler("z", 90 * quarter, degrees=True).as_matrix()
        moved, turned_half = place_box(replace(ROBOT, home=home), FD100_CENTER, FD100_HALF_EXTENT)
        assert_allclose(moved, turn @ center, atol=1e-12)
        assert_allclose(turned_half, np.abs(turn) @ half, atol=1e-12)


def test_an_arm_on_a_table_by_a_fixed_joint_is_the_one_on_the_floor(tmp_path):
    """A root link `world` and a fixed joint: the mount is the link that carries the first joint."""
    fixed = '<link name="world"/><joint name="m" type="fixed"><parent link="world"/><child link="base"/>{}</joint>'
    mount = '<origin xyz="0 0 2.5" rpy="3.141592653589793 0 0"/>'
    robots = [
        read_arm(tmp_path / name, changed(("</robot>", f"{fixed.format(where)}</robot>")))
        for name, where in {"floor": "", "ceiling": mount}.items()
    ]
    floor, ceiling = robots
    assert_array_equal(floor.home, ceiling.home)
    (center, half), (hung, same_half) = map(ReachTask().target_box, robots)
    assert_allclose(hung, [center[0], -center[1], 2.5 - center[2]], atol=1e-12)
    assert_allclose(half, same_half, atol=1e-12)
    lean = changed(('xyz="0 0 0.1" rpy="0 0 0"/><axis xyz="0 0 1"', 'xyz="0 0 0.1" rpy="0 0 0"/><axis xyz="0 1 0"'))
    upright = read_arm(tmp_path / "lean", lean.replace("</robot>", f"{fixed.format(mount)}</robot>"))
    assert_array_equal(upright.chain.T_world_mount, np.eye(4))


def test_a_given_box_follows_nothing(tmp_path):
    """Numbers are in the world's frame."""
    table = read_arm(tmp_path, TABLE_MOUNT)
    assert ReachTask(target_center=(0.4, 0.0, 0.9)).target_box(table)[0].tolist() == [0.4, 0.0, 0.9]


def test_targets_are_in_the_world():
    """None counts from the end effector."""
    assert not ReachTask().draw_targets(ROBOT, rng(), 20).relative.any()


def test_targets_can_be_reached():
    """For every target there is a pose within the joint ranges whose end effector is there."""
    targets = positions(ReachTask(), 100)
    qpos, _ = reach_position(ROBOT, targets, np.tile(ROBOT.home, (100, 1)))
    assert norm(ROBOT.end_effector(qpos) - targets, axis=1).max() <= 1e-3


def test_box_that_is_half_out_of_reach_gives_targets_within():
    """Of a box around the end of the arm's reach only the part within is used."""
    targets = positions(ReachTask(target_center=(1.6, 0.0, 0.6), target_half_extent=(0.5, 0.2, 0.2)), 50)
    assert targets.shape == (50, 3)
    assert norm(targets - [0.0, 0.0, 0.43], axis=1).max() < ROBOT.reach


def test_box_out_of_reach_is_refused():
    """A box 5 m away raises UsageError, which names the box."""
    task = ReachTask(target_center=(5.0, 0.0, 0.0))
    with refused(r"\(5, 0, 0\)"):
        task.draw_targets(ROBOT, rng(), 16)


def test_as_many_targets_as_asked_for():
    """One target, or a hundred."""
    for count in (1, 100):
        position, relative = ReachTask().draw_targets(ROBOT, rng(), count)
        assert (position.shape, relative.shape) == ((count, 3), (count,))


def test_starts_are_near_home():
    """Each joint starts within the noise of the home pose, and uses all of it."""
    task = ReachTask()
    generator = rng()
    away = np.abs([task.draw_start(ROBOT, generator) - ROBOT.home for _ in range(300)])
    assert away.max() <= task.start_noise == math.radians(6)
    assert (away.max(axis=0) > 0.9 * task.start_noise).all()


SHORT_SLIDE = """<robot name="slide">
<link name="base"/><link name="l1"/><link name="l2"/><link name="l3"/><link name="tool"/>
<joint name="j1" type="revolute"><parent link="base"/><child link="l1"/><origin xyz="0 0 0.35"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" velocity="2" effort="50"/></joint>
<joint name="j2" type="prismatic"><parent link="l1"/><child link="l2"/><origin xyz="0 0 0.25"/><axis xyz="0 0 1"/>
<limit lower="0" upper="0.05" velocity="0.2" effort="9"/></joint>
<joint name="j3" type="revolute"><parent link="l2"/><child link="l3"/><origin xyz="0 0 0.25"/><axis xyz="1 0 0"/>
<limit lower="-2" upper="2" velocity="2" effort="50"/></joint>
<joint name="jt" type="fixed"><parent link="l3"/><child link="tool"/><origin xyz="0.05 0 0.1"/></joint></robot>"""


def test_a_slide_starts_within_a_share_of_its_range(tmp_path):
    """A slide of 5 cm starts within 0.83 mm of home, as 6 degrees are 1/60 of a turn; and uses all of that."""
    (tmp_path / "slide.urdf").write_text(SHORT_SLIDE)
    robot, task, generator = read_robot(tmp_path / "slide.urdf"), ReachTask(), rng()
    away = np.abs([task.draw_start(robot, generator) - robot.home for _ in range(300)]).max(axis=0)
    assert_array_less(away, [math.radians(6), 0.05 / 60, math.radians(6)])
    assert away[1] > 0.9 * 0.05 / 60
    assert "a slide +- 1.67% of its range" in task.start_in_words(robot)
    assert "slide" not in task.start_in_words(ROBOT)


def test_starts_are_within_the_joint_ranges():
    """However large the noise, no joint starts beyond an end of its range."""
    task = ReachTask(start_noise=10.0)
    generator = rng()
    starts = np.array([task.draw_start(ROBOT, generator) for _ in range(100)])
    assert (starts >= ROBOT.lower).all()
    assert (starts <= ROBOT.upper).all()


def test_same_stream_gives_same_targets():
    """Starts and targets depend on the random stream alone."""
    task = ReachTask()
    assert_array_equal(positions(task, 20), positions(task, 20))
    assert_array_equal(task.draw_start(ROBOT, rng()), task.draw_start(ROBOT, rng()))


def test_motion_has_the_task_shares():
    """The motion is limited to the task's shares of the robot's maxima."""
    motion = ReachTask(speed=0.5, acceleration=0.25, control_period=0.2).motion(ROBOT)
    assert_allclose(motion.limits.max_speed, 0.5 * ROBOT.max_speed)
    assert_allclose(motion.limits.max_change, 0.25 * 0.2 * ROBOT.max_acceleration)


def test_every_target_pays_the_same():
    """Whatever the pose, NOTE eq. 19."""
    assert_array_equal(ReachTask(target_reward=2.5).target_rewards(ROBOT, np.zeros((3, 6))), [2.5] * 3)


def test_bad_override_is_a_usage_error(subtests):
    """An override that cannot be is refused in one line that names it."""
    for override, message in [
        ("epsilon=0", "epsilon"),
        ("epsilon=-0.1", "epsilon"),
        ("epsilon=wide", "epsilon"),
        ("epsilon=nan", "epsilon"),
        ("epsilon=inf", "epsilon"),
        ("horizon=0", "horizon"),
        ("horizon=1.5", "horizon"),
        ("control_period=0", "control_period"),
        ("target_center=1x2", "target_center"),
        ("target_half_extent=0.1x-0.1x0.1", "target_half_extent"),
        ("start_noise=-1", "start_noise"),
        ("speed=0", "speed"),
        ("speed=1.1", "speed"),
        ("acceleration=2", "acceleration"),
        ("ground_reward=nan", "ground_reward"),
        ("action=moveq", "moveq"),
        ("action=movel:frame=xyz", "frame"),
        ("gravity=9.81", "gravity"),
        ("epsilon", "epsilon"),
    ]:
        with subtests.test(override=override), refused(message):
            harness.make_env(task=f"fd100-reach:{override}")


def test_good_overrides_reach_the_env():
    """Every kind of override arrives, as text and as a mapping."""
    env = harness.make_env(task="fd100-reach:epsilon=0.02,horizon=7,target_center=0.8x0.1x0.6")
    assert (env.task.epsilon, env.task.horizon, env.task.target_center) == (0.02, 7, (0.8, 0.1, 0.6))
    env = harness.make_env(task={"name": "fd100-reach", "epsilon": 0.03})
    assert env.task.epsilon == 0.03


def test_epsilon_is_a_share_of_the_reach(tmp_path, subtests):
    """The default; one that is given stays, also if it is the FD100's, and so does every one of the FD100."""
    arm = tmp_path / "arm" / "arm.urdf"
    scale = read_arm(arm.parent, changed()).reach / ROBOT.reach
    for name, default in {
        "fd100-reach": 0.05,
        "fd100-low": 0.02,
        "fd100-pose": 0.02,
        "fd100-small-target": 0.01,
        "fd100-moving": 0.05,
        "noisy-reach": 0.02,
        "varied-reach": 0.03,
    }.items():
        with subtests.test(name):
            assert harness.make_env("kinematic", name).task.epsilon == default
            scaled = harness.make_env("kinematic", name, robot=arm).task.epsilon
            assert scaled == pytest.approx(scale * default, rel=5e-3)
            assert harness.make_env("kinematic", f"{name}:epsilon={default}", robot=arm).task.epsilon == default
    assert harness.make_env("kinematic", "unity-reach", robot=arm).task.epsilon == 0.05


def test_all_lengths_of_a_task_are_shares_of_the_reach(tmp_path):
    """The speed of a target, the noise on it, and the sizes of obstacles."""
    robot = read_arm(tmp_path, changed())
    arm, scale = tmp_path / "arm.urdf", robot.reach / ROBOT.reach
    for name, keys in {
        "fd100-moving": ("target_speed",),
        "noisy-reach": ("target_noise",),
        "cluttered-reach": ("obstacle_size", "obstacle_clearance"),
    }.items():
        usual, scaled = (harness.make_env("kinematic", name, robot=it).task for it in (None, arm))
        for key in keys:
            assert_allclose(getattr(scaled, key), scale * np.array(getattr(usual, key)), rtol=5e-3)


def test_a_task_for_another_arm_keeps_its_numbers():
    """They were chosen for that one."""

    class Own(ReachTask):
        robot = "unity-arm"

    assert Own().defaults_for(ROBOT) == {}


def test_a_scaled_length_is_the_same_everywhere():
    """Three digits; and the number itself for the FD100, whatever rounding does to its reach."""
    same, third = replace(ROBOT, chain=ROBOT.chain), replace(ROBOT, chain=ROBOT.chain)
    same.__dict__["reach"] = ROBOT.reach * (1.0 + 1e-12)
    assert same.scaled(0.0123456) == 0.0123456
    third.__dict__["reach"] = ROBOT.reach / 3.0
    assert third.scaled(0.05) == 0.0167


def test_epsilon_that_covers_the_box_does_not_pass_the_check():
    """Said before anything is run, too."""
    with refused("epsilon=3 m covers the targets"):
        ReachTask(epsilon=3.0).check(ROBOT)


def test_epsilon_that_covers_the_box_is_refused():
    """Where every target is reached before the first step, the task says so."""
    with refused("epsilon=3"):
        harness.make_env(task="fd100-reach:epsilon=3").reset(seed=0)


@pytest.mark.parametrize("horizon", [10**9 + 1, 10**20])
def test_an_episode_is_no_longer_than_a_training(horizon):
    """As `--steps` is bounded."""
    with pytest.raises(ValueError, match="less than or equal to 1000000000"):
        ReachTask(horizon=horizon)


@pytest.mark.parametrize("name", ["ground_reward", "target_reward", "step_reward"])
def test_what_is_paid_is_bounded(name):
    """Sums of what is paid stay finite."""
    with pytest.raises(ValueError, match="1000000000000000000"):
        ReachTask(**{name: -1e308})
