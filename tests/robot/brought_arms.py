"""An arm of four joints as people bring it: the URDF that all cases of these tests change."""

import numpy as np
import pinocchio
from numpy.random import default_rng

from harness.registry import choose
from harness.robot.robot import read_robot
from tests.registered import REGISTRY

BODY = (
    '<inertial><origin xyz="0 0 0.1"/><mass value="1.0"/>'
    '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
)
LIMIT = '<limit lower="-2" upper="2" velocity="2" effort="50"/>'


def _joint(name, parent, child, origin, axis):
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{origin}" rpy="0 0 0"/><axis xyz="{axis}"/>{LIMIT}</joint>\n'
    )


TOOL_JOINT = '<joint name="jt" type="fixed"><parent link="l4"/><child link="tool"/><origin xyz="0.05 0 0.1"/></joint>\n'
ARM = (
    '<?xml version="1.0"?>\n<robot name="a">\n'
    + "".join(f'<link name="{name}">{BODY}</link>\n' for name in ("base", "l1", "l2", "l3", "l4"))
    + '<link name="tool"/>\n'
    + _joint("j1", "base", "l1", "0 0 0.1", "0 0 1")
    + _joint("j2", "l1", "l2", "0 0 0.25", "0 1 0")
    + _joint("j3", "l2", "l3", "0 0 0.25", "0 1 0")
    + _joint("j4", "l3", "l4", "0 0 0.25", "1 0 0")
    + TOOL_JOINT
    + "</robot>\n"
)


def opened(robot, simulator):
    """One of it, in a simulator by its name."""
    return choose(REGISTRY, "simulators", simulator).build(REGISTRY, "simulators").open(robot, 1, 0.1)


def changed(*pairs, text=ARM):
    """The arm with texts replaced by others, wherever they stand; each of them has to be there."""
    for old, new in pairs:
        assert old in text, old
        text = text.replace(old, new)
    return text


def in_joint(joint, more, text=ARM):
    """The arm with more in one of its joints."""
    end = text.index("</joint>", text.index(f'<joint name="{joint}"'))
    return text[:end] + more + text[end:]


TABLE_MOUNT = changed(('xyz="0 0 0.1" rpy', 'xyz="0 0 0.8" rpy'))
JAW = changed(
    (
        "</robot>",
        f'<link name="jaw">{BODY}</link>{_joint("gripper", "tool", "jaw", "0 0 0.05", "0 0 1")}<link name="tcp"/>'
        '<joint name="jtcp" type="fixed"><parent link="tool"/><child link="tcp"/><origin xyz="0 0 0.12"/></joint>'
        "</robot>",
    )
)
BROUGHT = {
    "plain": ARM,
    "limits of a fixed joint are 0": in_joint(
        "jt", '<axis xyz="0 0 0"/><limit lower="0" upper="0" effort="0" velocity="0"/>'
    ),
    "limits of a fixed joint are empty": in_joint("jt", '<limit lower="" upper="" effort="" velocity=""/>'),
    "a prefix that nothing declares": ARM.replace("<limit lower", '<limit drake:acceleration="2.5" lower', 1),
    "a default namespace": changed(('<robot name="a"', '<robot name="a" xmlns="http://www.ros.org"')),
    "a jaw": JAW,
    "mounted on a table": TABLE_MOUNT,
    "colours, friction and a name that are none": changed(
        ('<robot name="a">', "<robot>"),
        (
            '<link name="l1">',
            '<link name="l1"><visual><geometry><sphere radius="0.1"/></geometry><material name="m"><color rgba="red"/>'
            '</material></visual><visual><geometry><sphere radius="0.1"/></geometry><material name="n">'
            '<color rgba="1 0 0"/></material></visual>',
        ),
        text=in_joint("j2", '<dynamics damping="nan" friction="nan"/>'),
    ),
}
"""What has to be read as it stands."""


def read_arm(folder, text, toml=""):
    """The robot of a URDF's text, and of a robot.toml where one is given."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "arm.urdf").write_text(text)
    if toml:
        (folder / "robot.toml").write_text(toml)
    return read_robot(folder / "arm.urdf")


def poses_of(robot):
    """Twenty random poses within the ranges, (20, dof)."""
    return default_rng(0).uniform(robot.lower, robot.upper, (20, robot.dof))


def tips_of_pinocchio(text, robot, poses):
    """Where Pinocchio, which reads URDFs with ROS's parser, has the end effector, (count, 3)."""
    model = pinocchio.buildModelFromXML(text)
    data, frame = model.createData(), model.getFrameId(robot.end_effector_link)
    assert frame < model.nframes
    tips = []
    for pose in poses:
        qpos = pinocchio.neutral(model)
        for name, position in zip(robot.joint_names, pose, strict=True):
            joint = model.joints[model.getJointId(name)]
            turn = [np.cos(position), np.sin(position)]  # what Pinocchio has of a continuous joint
            qpos[joint.idx_q : joint.idx_q + joint.nq] = turn if joint.nq == 2 else [position]
        pinocchio.framesForwardKinematics(model, data, qpos)
        tips.append(data.oMf[frame].translation.copy())
    return np.array(tips)
