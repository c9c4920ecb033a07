"""What robot.toml changes of an arm: where it stands, what it holds, where it begins and ends, how far it moves."""

import math
from itertools import pairwise

import numpy as np
import pinocchio
import pytest
from numpy.testing import assert_allclose

from tests.refusals import refused
from tests.robot.brought_arms import ARM, BODY, LIMIT, changed, opened, poses_of, read_arm

WALL = "base = { xyz_m = [1.2, -0.3, 0.9], rpy_deg = [0, 90, 0] }\n"
CEILING = "base = { xyz_m = [0.2, 0.1, 1.8], rpy_deg = [180, 0, 35] }\n"
TABLE = "base = { xyz_m = [0, 0, 0.75] }\n"
BASES = {
    WALL: ((1.2, -0.3, 0.9), (0, 90, 0)),
    CEILING: ((0.2, 0.1, 1.8), (180, 0, 35)),
    TABLE: ((0, 0, 0.75), (0, 0, 0)),
    "base = { xyz_m = [0.3, -1.1, 1], rpy_deg = [12.5, -33, 140] }\n": ((0.3, -1.1, 1), (12.5, -33, 140)),
}
"""Where an arm stands, and the same in numbers."""
PROBED = (0.01, -0.02, 0.13), (10, 20, 30)
PROBE = 'tool = { xyz_m = [0.01, -0.02, 0.13], rpy_deg = [10, 20, 30], name = "probe" }\n'
HOME = "home_deg = [0, 20, 40, 0]\n"
FINGERS = changed(
    (
        "</robot>",
        f'<link name="f">{BODY}</link><link name="g">{BODY}</link>'
        '<joint name="jf" type="prismatic"><parent link="tool"/><child link="f"/><axis xyz="0 1 0"/>'
        '<limit lower="0" upper="0.04" velocity="1" effort="1"/></joint>'
        '<joint name="jg" type="prismatic"><parent link="tool"/><child link="g"/><axis xyz="0 1 0"/>'
        '<limit lower="-1" upper="1" velocity="1" effort="1"/>'
        '<mimic joint="jf" multiplier="-2" offset="0.01"/></joint></robot>',
    )
)
"""The arm with a finger, and one that mimics it."""


def long_arm(count):
    """The URDF of an arm of so many turning joints, j1 and so on, from link l0 to the last one."""
    links = "".join(f'<link name="l{number}"/>' for number in range(count + 1))
    joints = "".join(
        f'<joint name="j{after}" type="revolute"><parent link="l{before}"/><child link="l{after}"/>'
        f'<origin xyz="0.01 0.02 0.3"/><axis xyz="{after % 2} {1 - after % 2} 0"/>{LIMIT}</joint>'
        for before, after in pairwise(range(count + 1))
    )
    return f'<robot name="long">{links}{joints}</robot>'


def pose(xyz, rpy_deg):
    """Pinocchio's own, of the numbers of a table of robot.toml."""
    return pinocchio.SE3(pinocchio.rpy.rpyToMatrix(*np.radians(rpy_deg)), np.array(xyz, dtype=float))


def tips(text, robot, poses, link, held=None):
    """Pinocchio's poses of a link of the URDF as it was given, with the joints `held` at their values."""
    model = pinocchio.buildModelFromXML(text)
    data, frame = model.createData(), model.getFrameId(link)
    assert frame < model.nframes
    found = []
    for each in poses:
        qpos = pinocchio.neutral(model)
        for name, value in {**(held or {}), **dict(zip(robot.joint_names, each, strict=True))}.items():
            qpos[model.joints[model.getJointId(name)].idx_q] = value
        pinocchio.framesForwardKinematics(model, data, qpos)
        found.append(data.oMf[frame].copy())
    return found


def differ(robot, poses, frames):
    """The largest difference of the end effector to the origins of frames, [m]."""
    return float(np.abs(robot.end_effector(poses) - [frame.translation for frame in frames]).max())


@pytest.mark.parametrize("toml", BASES, ids=["wall", "ceiling", "table", "anywhere"])
@pytest.mark.parametrize("tool", ["", PROBE], ids=["bare", "with a tool"])
def test_arm_stands_where_its_base_is(tmp_path, toml, tool):
    """The tip is Pinocchio's, seen from the base, with the tool's frame behind it."""
    robot = read_arm(tmp_path, ARM, toml + tool + HOME)
    poses, behind = poses_of(robot), pose(*PROBED) if tool else pinocchio.SE3.Identity()
    wanted = [pose(*BASES[toml]) * frame * behind for frame in tips(ARM, robot, poses, "tool")]
    assert robot.end_effector_link == ("probe" if tool else "tool")
    assert differ(robot, poses, wanted) <= 1e-12
    assert differ(robot, poses, tips(ARM, robot, poses, "tool")) > 0.1  # else all bases were alike


@pytest.mark.parametrize("simulator", ["kinematic", "mujoco", "pybullet"])
@pytest.mark.parametrize("toml", [WALL, CEILING, TABLE], ids=["wall", "ceiling", "table"])
def test_every_simulator_has_the_mount_and_the_tool(tmp_path, simulator, toml):
    """Its end effector is Pinocchio's, at a speed above the one of the URDF too, and the mount touches no ground."""
    box = '<collision><geometry><box size="0.4 0.4 4"/></geometry></collision>'
    text = changed(('velocity="2"', 'velocity="0.1"'), ('<link name="base">', f'<link name="base">{box}'))
    speeds = "max_speed_deg_s = [170, 170, 170, 170]\n"
    robot = read_arm(tmp_path, text, toml + PROBE + HOME + speeds)
    simulation = opened(robot, simulator)
    simulation.place(robot.home[None])
    goal = robot.home + 0.9 * np.radians(170) * 0.5
    for step in range(1, 6):
        state = simulation.drive(robot.home[None] + step / 5 * (goal - robot.home), 0.1)
    reached = state.qpos[0].copy()
    assert_allclose(reached, goal, rtol=0, atol=0.1)  # at 0.1 rad/s they would have moved by 0.05
    frame = tips(text, robot, reached[None], "tool")[0]
    wanted = pose(*BASES[toml]) * frame * pose(*PROBED)
    assert_allclose(state.end_effector[0], wanted.translation, rtol=0, atol=1e-6)
    assert not state.ground_contact[0]
    simulation.close()


def test_shapes_follow_the_mount(tmp_path):
    """A link's own frame stays; what no joint moves has no joint, as the new root."""
    box = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
    text = changed(*((f'<link name="{link}">', f'<link name="{link}">{box}') for link in ("base", "l1")))
    robot = read_arm(tmp_path, text, CEILING + HOME)
    assert [len(group) for group in robot.joint_shapes] == [1, 0, 0, 0]
    assert len(robot.link_shapes["base"]) == 1
    assert robot.link_shapes["world"] == ()


def test_held_joints_are_fixed_at_their_values(tmp_path):
    """In degrees where they turn, in metres where they slide; what mimics one follows; the others move."""
    robot = read_arm(tmp_path, FINGERS, 'end_effector = "g"\nfixed = { j3 = -35, jf = 0.03 }\n')
    poses = poses_of(robot)
    held = {"j3": math.radians(-35), "jf": 0.03, "jg": -2 * 0.03 + 0.01}
    assert robot.joint_names == ("j1", "j2", "j4")
    assert differ(robot, poses, tips(FINGERS, robot, poses, "g", held)) <= 1e-12
    assert differ(robot, poses, tips(FINGERS, robot, poses, "g", {**held, "jg": -0.03})) > 1e-3


def test_a_held_gripper_is_no_branch(tmp_path):
    """The end of the chain is found as if its joints were fixed ones."""
    text = changed(('"jg" type="prismatic"', '"jg" type="fixed"'), text=FINGERS)
    assert read_arm(tmp_path / "a", text).end_effector_link == "f"
    assert read_arm(tmp_path / "b", text, "fixed = { jf = 0.03 }").end_effector_link == "tool"


def test_arms_of_more_than_eight_joints_are_opened(tmp_path):
    """By joints that are held, or by where the chain begins."""
    text = long_arm(10)
    with refused(r"10 joints move .* hold some: fixed = .* or name .* chain = \[first, last\]"):
        read_arm(tmp_path, text)
    held = read_arm(tmp_path / "held", text, "fixed = { j2 = 30, j5 = -20 }\n")
    poses = poses_of(held)
    frames = tips(text, held, poses, "l10", {"j2": math.radians(30), "j5": math.radians(-20)})
    assert held.dof == 8
    assert differ(held, poses, frames) <= 1e-12


@pytest.mark.parametrize(
    "chain",
    [["l3", "l8"], ["j4", "j8"], ["l3", "j8"]],
    ids=["links", "joints", "both"],
)
def test_chain_begins_and_ends_where_it_is_said(tmp_path, chain):
    """Before it joints are at rest, or held; behind it they do not count."""
    text = changed(('<link name="l10"/>', '<link name="l10"/><link name="z"/>'), text=long_arm(10)).replace(
        "</robot>", '<joint name="jz" type="floating"><parent link="l9"/><child link="z"/></joint></robot>'
    )
    robot = read_arm(tmp_path, text, f"chain = {chain}\nfixed = {{ j2 = 30 }}\n")
    poses = poses_of(robot)
    assert (robot.joint_names, robot.end_effector_link) == (("j4", "j5", "j6", "j7", "j8"), "l8")
    assert differ(robot, poses, tips(text, robot, poses, "l8", {"j2": math.radians(30)})) <= 1e-12
    assert robot.origins["end_effector"] == "robot.toml"


def test_what_floats_before_the_chain_is_held(tmp_path):
    """A humanoid's first joint floats; the arm begins at its torso."""
    text = changed(('"j1" type="revolute"', '"j1" type="floating"'), text=long_arm(6))
    with refused("'j1' is of type 'floating'"):
        read_arm(tmp_path / "a", text)
    assert read_arm(tmp_path / "b", text, 'chain = ["l1", "l6"]').joint_names == ("j2", "j3", "j4", "j5", "j6")


def test_ranges_are_those_of_robot_toml(tmp_path):
    """By name or in the order of the chain, where the URDF has none, another, or a placeholder."""
    text = changed(
        ('lower="-2" upper="2"', 'lower="0" upper="0"'),
        ('"j4" type="revolute"', '"j4" type="continuous"'),
        ('<axis xyz="0 0 1"/><limit lower="0" upper="0" velocity="2" effort="50"/>', '<axis xyz="0 0 1"/>'),
    )
    speed = "max_speed_deg_s = { j1 = 90 }\n"
    rows = "range_deg = [[-170, 170], [-90, 120], [0, 150], [-100, 100]]\n"
    names = "range_deg = { j1 = [-170, 170], j4 = [-100, 100], j2 = [-90, 120], j3 = [0, 150] }\n"
    for number, toml in enumerate((rows, names)):
        robot = read_arm(tmp_path / str(number), text, speed + toml)
        assert_allclose(np.degrees(robot.lower), [-170, -90, 0, -100])
        assert_allclose(np.degrees(robot.upper), [170, 120, 150, 100])
        assert robot.chain.kinds == ("revolute",) * 4
        assert robot.urdf.count('lower="0"') == 0  # engines have the same
    assert read_arm(tmp_path / "plain", ARM, rows).urdf != read_arm(tmp_path / "bare", ARM).urdf


def test_range_of_a_slide_is_in_metres(tmp_path):
    """And the line that refuses a placeholder is what to write."""
    text = changed(('"j2" type="revolute"', '"j2" type="prismatic"'), ('lower="-2" upper="2"', 'lower="0" upper="0"'))
    text = text.replace('"0" upper="0"', '"-2" upper="2"', 1).replace('"0" upper="0"', '"0" upper="0.0"', 1)
    text = text.replace('upper="0"', 'upper="1"')
    with refused("'j2' has the limits 0 to 0") as caught:
        read_arm(tmp_path / "a", text)
    line = str(caught.value).rpartition("in a robot.toml: ")[2]
    assert line == 'range_m = { "j2" = [0, 0.2] }'
    robot = read_arm(tmp_path / "b", text, line)
    assert (robot.lower[1], robot.upper[1]) == (0.0, 0.2)


def test_a_name_that_is_taken_is_no_obstacle(tmp_path):
    """A root that is called world stands on another one; MuJoCo, which knows the name, has it there too."""
    text = changed(('"base"', '"world"'), ('"l3"', '"mount"'), ('"j4"', '"world_to_mount_"'))
    robot = read_arm(tmp_path, text, TABLE)
    poses = poses_of(robot)
    wanted = [pose(*BASES[TABLE]) * frame for frame in tips(text, robot, poses, "tool")]
    assert differ(robot, poses, wanted) <= 1e-12
    simulation = opened(robot, "mujoco")
    assert_allclose(simulation.place(poses[:1]).end_effector[0], wanted[0].translation, rtol=0, atol=1e-12)
    simulation.close()


@pytest.mark.parametrize("toml", ["", 'name = "b"\n', "max_speed_deg_s = [9, 9, 9, 9]\n"])
def test_without_these_keys_the_urdf_stays_as_it_is(tmp_path, toml):
    """So cells that were done with such an arm go on; a base makes another arm of it."""
    text = changed(('<link name="tool"/>', f'<link name="tool">{BODY}</link>'))
    robot = read_arm(tmp_path, text, toml)
    assert robot.urdf == text
    assert read_arm(tmp_path / "b", text, toml + TABLE).digest != robot.digest


REFUSED = {
    "base = 5": r"robot.toml: base is 5. Write a table: \[base\]",
    "base = { xyz = [0, 0, 1] }": r"\[base\]: unknown xyz. The keys are xyz_m, rpy_deg",
    "base = { xyz_m = [0, 1] }": r"\[base\]: xyz_m is \[0, 1\]. Give a list of three finite numbers",
    "base = { rpy_deg = [0, 1, nan] }": "rpy_deg is .*. Give a list of three finite numbers",
    'tool = { name = "l3" }': r"\[tool\]: name is 'l3', a link of the URDF. Give another",
    "tool = { name = [5] }": r"name is \[5\]. Give another, in quotes",
    "tool = { name = 5 }": "name is 5. Give another, in quotes",
    'tool = { name = "world" }': "name is 'world'. Give another",
    'tool = {}\nend_effector = "hand"': "arm.urdf: No link 'hand' in the URDF",
    "fixed = [1]": r"robot.toml: fixed is \[1\]. Give a table of joints by name",
    "fixed = { j33 = 1 }": r"robot.toml: fixed names 'j33'. Did you mean 'j3'\? Joints that move: 'j1', 'j2'",
    "fixed = { jt = 1 }": "fixed names 'jt'",
    "fixed = { j3 = true }": "fixed of 'j3' is True. Give a number of degrees",
    "fixed = { j3 = 200 }": "fixed of 'j3' is 200; allowed: -114.592 to 114.592 deg, its range in the URDF. Correct it",
    'chain = "l3"': "chain is 'l3'. Give a list of 2 texts",
    'chain = ["l1", "tol"]': r"chain names 'tol', no link or joint. Did you mean 'tool'\? The links: 'base', 'l1'",
    'chain = ["l4", "l1"]': "chain begins at 'l4', which does not carry 'l1'. Correct it",
    'chain = ["base", "l4"]\nend_effector = "tool"': "chain ends at 'l4', end_effector is 'tool'. Keep one",
    "range_deg = [[0, 1]]": "range_deg has 1 values for 4 turning joints",
    "range_deg = { j1 = [1, 0] }": "range_deg of 'j1' is .*. Give two finite numbers, the lower one first",
    "range_deg = { j1 = 90 }": "range_deg of 'j1' is 90. Give two",
    "range_m = { j1 = [0, 1] }": "range_m names 'j1'. The sliding joints of the arm: none",
    "meshes = 5": "meshes is 5. Give a folder in quotes, or a table of folders by package",
    'meshes = { a = "nowhere" }': "meshes names 'nowhere': no folder '.*nowhere'. Name one",
}


def test_what_cannot_be_is_refused_in_one_line(tmp_path_factory, subtests):
    """The file to correct, what is wrong, what is allowed."""
    for toml, message in REFUSED.items():
        with subtests.test(toml=toml):
            tmp_path = tmp_path_factory.mktemp("case")
            with refused(message) as caught:
                read_arm(tmp_path, ARM, toml)
            assert str(caught.value).startswith(str(tmp_path))
            assert str(caught.value).count(str(tmp_path)) <= 2  # a file is named once; a folder may be
