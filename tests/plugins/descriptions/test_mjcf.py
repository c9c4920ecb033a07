"""Arms in MJCF: what the harness makes of them is held against MuJoCo's own kinematics of the file as it stands."""

import os
import struct

import mujoco
import numpy as np
import pinocchio
import pytest
from numpy.linalg import norm
from numpy.random import default_rng

from harness.errors import UsageError
from harness.files import run_apart
from harness.robot import link_frames
from harness.robot.robot import read_robot
from harness_plugins.descriptions.mjcf import SPEEDS, Mjcf, _rotation, _rpy, _turn
from tests.plugins.descriptions.hostile_mjcf import MODELS, arm, write_hostile
from tests.robot.brought_arms import poses_of

ARM = """<!-- A licence may stand here. -->
<mujoco model="odd">
  <compiler angle="degree" eulerseq="XYZ"/>
  <default>
    <joint damping="1"/>
    <default class="bend"><joint axis="0 1 0" range="-100 110"/></default>
    <default class="seen"><geom contype="0" conaffinity="0" group="2"/></default>
  </default>
  <asset>
    <mesh name="wedge" file="wedge.stl" scale="0.002 0.001 0.003" refpos="0.3 -0.2 0.1"/>
    <mesh name="turned" file="wedge.stl" scale="0.001 0.001 0.001" refpos="1 2 3" refquat="0.9 0.1 -0.3 0.2"/>
  </asset>
  <worldbody>
    <geom type="plane" size="1 1 0.1"/>
    <body name="cube" pos="0.5 0 0.1"><freejoint/><geom type="box" size="0.02 0.02 0.02"/></body>
    <body name="table" pos="0 0 -0.2"><geom type="box" size="0.5 0.5 0.1"/></body>
    <frame pos="0.1 0.2 0.3" euler="10 20 30">
      <body name="base" pos="0 0 0.1">
        <geom type="cylinder" size="0.06 0.05" mass="2"/>
        <body name="shoulder" pos="0 0 0.1" quat="0.7 0.1 -0.2 0.3">
          <joint name="pan" axis="0.1 0.2 1" pos="0.01 0.02 0.03" range="-170 160"/>
          <joint name="lift" class="bend" pos="0 0.03 0.01" ref="25"/>
          <geom type="capsule" fromto="0 0 0 0.05 0 0.2" size="0.03"/>
          <geom type="mesh" mesh="wedge" pos="0.01 0 0.1" euler="40 -20 10"/>
          <body name="upper" pos="0 0.02 0.25" euler="0 90 0">
            <joint name="out" type="slide" axis="1 0.2 0" range="-0.05 0.2" ref="0.03"/>
            <geom type="box" size="0.02 0.03 0.1" pos="0 0 0.1" euler="5 6 7"/>
            <geom class="seen" type="ellipsoid" size="0.02 0.03 0.1"/>
            <body name="fore" pos="0.2 0 0.1">
              <joint name="roll" axis="1 0 0"/>
              <geom type="mesh" mesh="turned" pos="0 0.1 0" euler="1 2 3"/>
              <geom type="sphere" size="0.04" pos="0.1 0 0"/>
              <body name="hand" pos="0.15 0 0" euler="0 90 0">
                <joint name="bend" class="bend" pos="0 0 -0.02"/>
                <inertial pos="0.01 0.02 0.03" mass="0.7" fullinertia="0.003 0.004 0.005 0.0003 0.0002 0.0001"/>
                <geom class="seen" type="mesh" mesh="wedge"/>
                <site name="attachment_site" pos="0.01 0 0.12" euler="0 0 45"/>
                <body name="left" pos="0 0.02 0.1">
                  <joint name="left_finger" type="slide" axis="0 1 0" range="0.01 0.04"/>
                  <geom type="box" size="0.01 0.01 0.02"/>
                </body>
                <body name="right" pos="0 -0.02 0.1">
                  <joint name="right_finger" type="slide" axis="0 -1 0" range="0 0.04"/>
                  <geom type="box" size="0.01 0.01 0.02"/>
                </body>
              </body>
            </body>
          </body>
        </body>
      </body>
    </frame>
  </worldbody>
  <equality><joint joint1="left_finger" joint2="right_finger"/></equality>
  <actuator>
    <velocity joint="pan" kv="10" ctrlrange="-2 2" gear="4"/>
    <position joint="lift" kp="10" ctrlrange="-1 1"/>
  </actuator>
  <keyframe><key name="home" qpos="0.5 0 0.1 1 0 0 0  0.1 0.5 0.05 4 -0.3 0.02 0.02"/></keyframe>
</mujoco>
"""
SIMPLE = ARM.replace('<body name="cube" pos="0.5 0 0.1"><freejoint/>', '<body name="cube" pos="0.5 0 0.1">')
DIRECTIONS = default_rng(1).normal(size=(40, 3))


def write_arm(folder, text=ARM):
    """The file of an arm, with a mesh of a tetrahedron beside it."""
    corners = np.array([[0, 0, 0], [40, 0, 0], [0, 30, 0], [10, 10, 50]], float)
    faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
    triangles = b"".join(struct.pack("<12fH", 0, 0, 0, *corners[list(face)].ravel(), 0) for face in faces)
    (folder / "wedge.stl").write_bytes(bytes(80) + struct.pack("<I", len(faces)) + triangles)
    (folder / "arm.xml").write_text(text)
    return folder / "arm.xml"


def posed(path, robot, pose):
    """MuJoCo's own arm, its other joints where the harness fixes them."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    data.joint("left_finger").qpos = 0.01
    for name, position in zip(robot.joint_names, pose, strict=True):
        data.joint(name).qpos = position
    mujoco.mj_forward(model, data)
    return model, data


def refused(folder, text):
    """What is said of a file."""
    with pytest.raises(UsageError) as error:
        read_robot(write_arm(folder, text))
    return str(error.value)


def test_tips_are_those_of_mujoco(tmp_path):
    """With degrees, classes, a frame, anchors, several joints of a body, and positions at rest that are not 0."""
    path = write_arm(tmp_path)
    robot = read_robot(path)
    assert robot.joint_names == ("pan", "lift", "out", "roll", "bend")
    assert robot.end_effector_link == "attachment_site"
    for pose in poses_of(robot):
        _, data = posed(path, robot, pose)
        assert np.abs(robot.end_effector(pose) - data.site("attachment_site").xpos).max() <= 1e-12


def test_every_body_is_a_tip(tmp_path, subtests):
    """A link has its body's frame, also where the body's joint turns elsewhere."""
    path = write_arm(tmp_path)
    for link in ("upper", "fore", "hand"):
        with subtests.test(link=link):
            (tmp_path / "robot.toml").write_text(f'end_effector = "{link}"\n')
            robot = read_robot(path)
            pose = poses_of(robot)[0]
            assert np.abs(robot.end_effector(pose) - posed(path, robot, pose)[1].body(link).xpos).max() <= 1e-12


def test_ranges_are_those_of_mujoco(tmp_path):
    """In MuJoCo's own counting, `ref` included; without a range a joint turns freely."""
    path = write_arm(tmp_path)
    robot, model = read_robot(path), mujoco.MjModel.from_xml_path(str(path))
    for name, lower, upper in zip(robot.joint_names, robot.lower, robot.upper, strict=True):
        assert [lower, upper] == ([-np.pi, np.pi] if name == "roll" else model.joint(name).range.tolist())


def test_masses_and_inertias_are_those_of_mujoco(tmp_path):
    """The joint-space inertia of all joints, by Pinocchio of the URDF and by MuJoCo of the file."""
    path = write_arm(tmp_path)
    robot, model = read_robot(path), pinocchio.buildModelFromXML(Mjcf().read(path, {}, {}).urdf)
    for pose in poses_of(robot):
        own, data = posed(path, robot, pose)
        names = list(model.names)[1:]
        expected = np.array([inertia_times(own, data, column) for column in np.eye(own.nv)])
        numbers = [own.joint(name).dofadr[0] for name in names]
        turned = [data.joint(name).qpos for name in names]
        turned[names.index("roll")] = [np.cos(pose[3]), np.sin(pose[3])]
        found = pinocchio.crba(model, model.createData(), np.concatenate(turned))
        found = np.triu(found) + np.triu(found, 1).T
        assert np.abs(found - expected[np.ix_(numbers, numbers)]).max() <= 1e-12


def inertia_times(model, data, motion):
    """The joint-space inertia times a motion of all joints, by MuJoCo."""
    product = np.zeros(model.nv)
    mujoco.mj_mulM(model, data, product, motion)
    return product


def test_shapes_are_where_mujoco_has_them(tmp_path):
    """How far each reaches in forty directions; meshes are moved and turned to their own centre by MuJoCo."""
    path = write_arm(tmp_path)
    robot = read_robot(path)
    pose = poses_of(robot)[0]
    model, data = posed(path, robot, pose)
    frames = np.concatenate(
        [link_frames(robot.chain, pose[None])[..., 0], np.tile([[[0.0, 0.0, 0.0, 1.0]]], (5, 1, 1))], axis=1
    )
    found = [
        extent(frames[joint] @ shape.T_link_shape, shape) for joint in range(5) for shape in robot.joint_shapes[joint]
    ]
    touching = [geom for geom in range(model.ngeom) if model.geom_contype[geom]]
    moving = [geom for geom in touching if model.body(model.geom_bodyid[geom]).name in BODIES]
    expected = [extent_in_mujoco(model, data, geom) for geom in moving]
    assert len(found) == len(expected) == 7
    assert np.abs(np.array(found) - np.array(expected)).max() < 1e-7  # MuJoCo keeps points in single precision


BODIES = {"shoulder", "upper", "fore", "hand", "left", "right"}


def extent(pose, shape):
    """How far a shape of the harness reaches in all directions, (40,), [m]."""
    local = DIRECTIONS @ pose[:3, :3]
    if shape.kind == "mesh":
        reach = (local @ shape.points.T).max(axis=1)
    elif shape.kind == "box":
        reach = np.abs(local) @ np.array(shape.size) / 2
    else:
        long = shape.size[1] / 2 if shape.kind == "capsule" else 0.0
        reach = shape.size[0] * norm(local, axis=1) + np.abs(local[:, 2]) * long
    return DIRECTIONS @ pose[:3, 3] + reach


def extent_in_mujoco(model, data, geom):
    """The same of a shape of MuJoCo."""
    local, size = DIRECTIONS @ data.geom_xmat[geom].reshape(3, 3), model.geom_size[geom]
    kind = model.geom_type[geom]
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = model.mesh(model.geom_dataid[geom])
        reach = (local @ model.mesh_vert[mesh.vertadr[0] : mesh.vertadr[0] + mesh.vertnum[0]].T).max(axis=1)
    elif kind == mujoco.mjtGeom.mjGEOM_BOX:
        reach = np.abs(local) @ size
    else:
        long = size[1] if kind == mujoco.mjtGeom.mjGEOM_CAPSULE else 0.0
        reach = size[0] * norm(local, axis=1) + np.abs(local[:, 2]) * long
    return DIRECTIONS @ data.geom_xpos[geom] + reach


def test_home_is_the_keyframe(tmp_path):
    """Within the ranges: `roll` turns by 4 rad in the file, and half a turn is its end here."""
    robot = read_robot(write_arm(tmp_path))
    assert robot.home.tolist() == [0.1, 0.5, 0.05, np.pi, -0.3]
    assert robot.origins["home"] == "the keyframe 'home'"


def test_robot_toml_wins(tmp_path):
    """Of the resting pose, the end and the speeds."""
    path = write_arm(tmp_path)
    (tmp_path / "robot.toml").write_text(
        'end_effector = "hand"\nhome_deg = { pan = 10 }\nmax_speed_deg_s = [300, 90, 90, 90]\nmax_speed_m_s = [0.5]\n'
    )
    robot = read_robot(path)
    assert robot.home[:2].tolist() == [np.radians(10), 0.5]
    assert (robot.end_effector_link, robot.max_speed[1]) == ("hand", np.radians(90))
    assert SPEEDS not in robot.warnings


def test_speeds_are_taken_and_told(tmp_path):
    """MJCF has no place for them, but for the command of a motor that is told speeds: 2 at a gear of 4."""
    robot = read_robot(write_arm(tmp_path))
    assert robot.max_speed.tolist() == [0.5, np.pi, 0.125, np.pi, np.pi]
    assert SPEEDS in robot.warnings


def test_what_is_left_out_is_told(tmp_path):
    """Objects and tables around the arm, and shapes that a URDF has not; the plane of the ground is everybody's."""
    told = "\n".join(read_robot(write_arm(tmp_path)).warnings)
    assert "left out, as they are no part of the arm: 'cube', 'table'" in told
    assert "'upper' has a ellipsoid" not in told
    assert "'upper' has an ellipsoid, which is left out" in told
    assert "plane" not in told


def test_fixed_objects_are_left_out_too(tmp_path):
    """What has no joint is no arm."""
    assert (
        'name="cube"'
        not in read_robot(
            write_arm(tmp_path, SIMPLE.replace('<key name="home" qpos="0.5 0 0.1 1 0 0 0 ', '<key name="home" qpos="'))
        ).urdf
    )


def test_objects_that_float_are_left_out_with_their_joints(tmp_path):
    """A box with a lid is no second arm."""
    lid = '<body name="lid"><joint/><geom size="0.01"/></body>'
    text = (
        ARM[: ARM.index("<keyframe>")].replace('size="0.02 0.02 0.02"/>', f'size="0.02 0.02 0.02"/>{lid}') + "</mujoco>"
    )
    robot = read_robot(write_arm(tmp_path, text))
    assert robot.joint_names[0] == "pan"
    assert 'name="lid"' not in robot.urdf


def test_an_arm_that_floats_is_fixed_where_it_begins(tmp_path):
    """Told in a line, if nothing else moves."""
    text = ARM.replace('<geom type="cylinder" size="0.06', '<freejoint/><geom type="cylinder" size="0.06')
    text = text.replace("<frame pos", "<body pos").replace("</frame>", "</body>")
    text = text.replace('<body pos="0.1 0.2 0.3" euler="10 20 30">', "").replace(
        "</body>\n  </worldbody>", "</worldbody>"
    )
    text = text[: text.index("<keyframe>")] + "</mujoco>"
    robot = read_robot(write_arm(tmp_path, text))
    assert "'base' floats in the MJCF; here it is fixed where it begins" in robot.warnings


def test_loops_are_told(tmp_path):
    """A weld between links of the arm; not one within its gripper."""
    weld = '<equality><weld body1="{}" body2="{}"/>'
    told = read_robot(write_arm(tmp_path, ARM.replace("<equality>", weld.format("shoulder", "hand")))).warnings
    assert any("connect or weld" in line for line in told)
    quiet = read_robot(write_arm(tmp_path, ARM.replace("<equality>", weld.format("left", "right")))).warnings
    assert not any("connect or weld" in line for line in quiet)


def test_two_arms_ask_for_one(tmp_path):
    """And are read when it is named."""
    begin, end = ARM.index('<body name="base"'), ARM.index("</frame>")
    body = ARM[begin:end]
    second = body
    for name in ("base", "shoulder", "upper", "fore", "hand", "left", "right", "pan", "lift", "out", "roll", "bend"):
        second = second.replace(f'name="{name}', f'name="other_{name}')
    second = second.replace('name="attachment_site"', 'name="other_attachment_site"')
    text = ARM[:begin] + body + second + ARM[end : ARM.index("<keyframe>")] + "</mujoco>"
    assert "The arm branches at link 'world' into 'base', 'other_base'" in refused(tmp_path, text)
    (tmp_path / "robot.toml").write_text('end_effector = "other_attachment_site"\n')
    assert read_robot(tmp_path / "arm.xml").joint_names[0] == "other_pan"


REFUSED = {
    "a slide without a range": (' range="-0.05 0.2" ref="0.03"', "", "Joint 'out' is prismatic and has no limits"),
    "a ball": ('<joint name="roll" axis="1 0 0"/>', '<joint name="roll" type="ball"/>', "'roll' is of type 'floating'"),
    "a file that is not there": (
        'file="wedge.stl" scale="0.002',
        'file="no.stl" scale="0.002',
        "MuJoCo cannot read it",
    ),
    "a ref without digits": ('range="-0.05 0.2" ref="0.03"', 'range="-0.05 0.2" ref="9e18"', "has the ref 9e+18"),
    "no XML": ("</mujoco>", "", "not well-formed XML"),
}


def test_refusals(tmp_path, subtests):
    """In a sentence that begins with the file."""
    text = ARM[: ARM.index("<keyframe>")] + "</mujoco>"
    for case, (old, new, told) in REFUSED.items():
        with subtests.test(case):
            assert old in text
            said = refused(tmp_path, text.replace(old, new))
            assert said.startswith(str(tmp_path / "arm.xml"))
            assert told in said


def test_nothing_that_moves_is_refused(tmp_path):
    """A scene without an arm."""
    text = '<mujoco><worldbody><body name="cube"><geom size="1"/></body></worldbody></mujoco>'
    assert "Nothing in it turns or slides by a joint. Give the MJCF of an arm." in refused(tmp_path, text)


def test_names_that_come_twice_are_told_apart(tmp_path):
    """A site may be called as a body, and bodies and joints may have no name."""
    text = ARM.replace('"attachment_site"', '"hand"').replace(' name="fore"', "").replace(' name="roll"', "")
    (tmp_path / "robot.toml").write_text('end_effector = "hand_site"\n')
    robot = read_robot(write_arm(tmp_path, text))
    assert robot.end_effector_link == "hand_site"
    assert 'link name="body6"' in robot.urdf


def test_angles_are_exact_next_to_the_pole():
    """A pitch of 90 degrees, and a millionth beside it, where roll and yaw are hard to tell apart."""
    rng, up = default_rng(0), np.array([0.0, 1.0, 0.0])
    for aside in (0.0, 1e-16, 1e-9, 1e-7, 3.7e-6):
        pole = _turn(up, np.pi / 2 + aside)
        for turn in (
            _turn(np.eye(3)[2], angle) @ pole @ _turn(np.eye(3)[0], angle / 3) for angle in rng.uniform(-3, 3, 20)
        ):
            roll, pitch, yaw = _rpy(turn)
            again = _turn(np.eye(3)[2], yaw) @ _turn(up, pitch) @ _turn(np.eye(3)[0], roll)
            assert np.abs(again - turn).max() < 1e-15 * 4


def test_rotation_is_that_of_mujoco():
    """Of any quaternion."""
    quaternion = np.array([0.5, -0.1, 0.7, 0.2])
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, quaternion / norm(quaternion))
    assert np.allclose(_rotation(quaternion), matrix.reshape(3, 3), atol=1e-15)


@pytest.mark.parametrize("name", MODELS)
def test_a_hostile_model_is_refused_in_a_line(tmp_path, name):
    """Before MuJoCo sees it, or while another process reads it, and in no more than a second or so of computing."""
    path, before = write_hostile(tmp_path, name), os.times()
    with pytest.raises(UsageError) as error:
        read_robot(path)
    after = os.times()
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)
    assert sum(after[:4]) - sum(before[:4]) < 20.0


def test_a_model_that_is_large_is_read(tmp_path):
    """With copies, pictures and a height field within the bounds."""
    body = '<replicate count="100" offset="1 0 0"><geom size="1"/></replicate>'
    picture = '<texture name="t" type="2d" builtin="flat" width="1000" height="1000"/>'
    (tmp_path / "arm.xml").write_text(
        arm(f'<asset>{picture}<hfield name="h" nrow="9" ncol="9" size="1 1 1 1"/></asset>', body)
    )
    assert read_robot(tmp_path / "arm.xml").joint_names == ("turn", "lift", "bend")


def test_what_takes_too_long_or_too_much_is_ended():
    """Whatever a library does there: the process that reads is another one."""
    for word, seconds, told in (
        ("loop", 1, "1 s of computing"),
        ("fill", 60, "GiB of memory"),
        ("abort", 9, "SIGABRT"),
    ):
        with pytest.raises(UsageError, match=told):
            run_apart("tests.plugins.descriptions.endless", "end", word, cpu_seconds=seconds, memory=2**29)
    with pytest.raises(RuntimeError, match="ZeroDivisionError"):
        run_apart("tests.plugins.descriptions.endless", "end", "raise")


@pytest.mark.parametrize("folder", ["", "sub", "sub/arm"])
def test_meshes_are_found_wherever_the_command_stands(tmp_path, monkeypatch, folder):
    """From the file's folder, from above it, and by an absolute path."""
    (tmp_path / "sub/arm").mkdir(parents=True)
    path = write_arm(tmp_path / "sub/arm")
    monkeypatch.chdir(tmp_path / folder)
    relative = read_robot(path.relative_to(tmp_path / folder))
    assert np.array_equal(relative.end_effector(relative.home), read_robot(path).end_effector(relative.home))


def test_joints_that_are_coupled_are_told(tmp_path):
    """By an equality of joints, or of tendons of joints; not the fingers of a gripper."""
    tie = '<equality><joint joint1="bend" joint2="lift"/>'
    assert any(
        "couples 'lift' and 'bend'" in it
        for it in read_robot(write_arm(tmp_path, ARM.replace("<equality>", tie))).warnings
    )
    tendon = '<tendon><fixed name="t"><joint joint="pan" coef="1"/><joint joint="roll" coef="1"/></fixed></tendon>'
    text = ARM.replace("<equality>", f'{tendon}<equality><tendon tendon1="t"/>')
    assert any("couples 'pan' and 'roll'" in it for it in read_robot(write_arm(tmp_path, text)).warnings)
    assert not any("couples" in it for it in read_robot(write_arm(tmp_path)).warnings)


def test_a_keyframe_beyond_a_range_is_told(tmp_path):
    """What it says, and what is taken."""
    told = read_robot(write_arm(tmp_path)).warnings
    assert "the keyframe 'home' puts 'roll' at 229.2 deg, beyond its range: 180 deg is taken" in told
