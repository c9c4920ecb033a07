"""A URDF of joints and masses alone."""

from dataclasses import replace
from xml.etree import ElementTree

from harness_plugins.arms.bare_urdf import bare_urdf
from tests.registered import FD100 as ROBOT

ENDLESS = """<robot name="endless"><link name="base"><inertial><mass value="3"/></inertial></link><link name="l"/>
<joint name="j" type="continuous"><parent link="base"/><child link="l"/><limit lower="0" upper="0"/></joint></robot>"""


def test_only_joints_and_masses_are_left():
    """Nothing to see, to touch, to rub or to damp."""
    text, _ = bare_urdf(ROBOT)
    tags = {element.tag for element in ElementTree.fromstring(text).iter()}
    assert tags == {
        "robot", "link", "joint", "inertial", "origin", "mass", "inertia", "parent", "child", "axis", "limit",
    }  # fmt: skip


def test_joints_and_masses_are_those_of_the_robot():
    """Word for word, but for the root link's mass."""
    bare, whole = ElementTree.fromstring(bare_urdf(ROBOT)[0]), ElementTree.fromstring(ROBOT.urdf)
    for path in ("joint/origin", "joint/axis", "joint/limit", "joint/child"):
        assert [each.attrib for each in bare.findall(path)] == [each.attrib for each in whole.findall(path)]
    masses = [[each.attrib for each in urdf.findall("link/inertial/mass")] for urdf in (bare, whole)]
    assert masses[0] == masses[1][1:]


def test_root_link_is_named_and_weighs_nothing():
    """It stands still; engines that take a link called world for their own allow it no mass."""
    text, root = bare_urdf(replace(ROBOT, urdf=ENDLESS))
    assert root == "base"
    assert ElementTree.fromstring(text).find("link/inertial") is None


def test_joint_without_end_has_no_range():
    """Drake would lock a continuous joint whose limits are 0."""
    assert "limit" not in bare_urdf(replace(ROBOT, urdf=ENDLESS))[0]


def test_robot_stays_as_it_is():
    """What is taken out is taken out of a copy."""
    before = ROBOT.urdf
    bare_urdf(ROBOT)
    assert ROBOT.urdf == before
    assert "collision" in before
