"""URDFs as other people write them: each is read as ROS's parser reads it, or refused in one line."""

from random import Random
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harness.robot.robot import read_robot
from tests.refusals import refused
from tests.robot.brought_arms import (
    ARM,
    BODY,
    BROUGHT,
    LIMIT,
    TOOL_JOINT,
    changed,
    in_joint,
    opened,
    poses_of,
    read_arm,
    tips_of_pinocchio,
)

NOT_READ_BY_ROS = {"limits of a fixed joint are empty", "colours, friction and a name that are none"}
"""ROS's parser judges the limits of every joint, and what is only drawn. The arm is the plain one."""
BESIDE = (
    '<link name="f"/><link name="g"/>'
    '<joint name="jf" type="revolute"><parent link="tool"/><child link="f"/>{}</joint>'
    '<joint name="jg" type="revolute"><parent link="tool"/><child link="g"/></joint></robot>'
)
"""Two fingers, one of which has more in it."""
ALIKE = {
    "a mark of the byte order": "\ufeff" + ARM,
    "blank lines before the declaration": "\n \n" + ARM,
    "no declaration": ARM.partition("\n")[2],
    "elements with a prefix": changed(('<link name="tool"/>', '<link name="tool"/><drake:a b:c="1"><link/></drake:a>')),
    "a declared prefix": changed(("<robot", '<robot xmlns:d="http://d"'), ("<limit", '<limit d:acceleration="2"')),
    "an axis with a word of a fixed joint": in_joint("jt", '<axis xyz="a b"/>'),
    "a range the wrong way round of a fixed joint": in_joint(
        "jt", '<limit lower="2" upper="1" velocity="0" effort="0"/>'
    ),
    "a fixed joint that mimics": in_joint("jt", '<mimic joint="j1"/>'),
    "an axis that is not normalised": changed(('xyz="0 1 0"', 'xyz="0 20 0"')),
    "an axis of x is left out": changed(('<axis xyz="1 0 0"/>', "")),
    "no rpy": changed((' rpy="0 0 0"', "")),
    "exponents and signs": changed(('"0 0 0.25"', '" 0  -0e5 +2.5E-1 "')),
    "a second origin": changed(
        ('<origin xyz="0.05 0 0.1"/>', '<origin xyz="0.05 0 0.1"/><origin xyz="1 2 3" rpy="1 0 0"/>')
    ),
    "joints out of order": changed((TOOL_JOINT, ""), ('<link name="base">', TOOL_JOINT + '<link name="base">')),
    "parts of other programs": changed(
        ("</robot>", '<gazebo reference="l1"/><transmission name="t"><joint name="j1"/></transmission></robot>')
    ),
    "entities and CDATA": changed(("</robot>", "<![CDATA[<link/>]]></robot>"), ('name="tool"', 'name="&#116;ool"')),
}
"""The arm in other words: ROS's parser reads all of them."""
REFUSED = {
    "a comma": ('"0 0 0.25"', '"0, 0, 0.25"', "Joint 'j2' has '0,' where a finite number belongs"),
    "a number of Python": ('"0 0 0.25"', '"0 0 0_1"', "Joint 'j2' has '0_1' where a finite number belongs"),
    "an infinity": ('"0 0 0.25"', '"0 0 inf"', "Joint 'j2' has 'inf' where a finite number belongs"),
    "an empty origin": ('"0 0 0.25"', '""', "Joint 'j2' has 0 numbers in <origin xyz=...>"),
    "tags in capitals": ('<link name="tool"/>', '<Link name="tool"/>', "links that the URDF does not define: 'tool'"),
    "two roots": ('<link name="tool"/>', '<link name="tool"/><link name="z"/>', "found: 'base', 'z'"),
    "two of a name": ('name="j2"', 'name="j1"', "more than one joint 'j1'"),
    "a joint that mimics": (
        '<axis xyz="1 0 0"/>',
        '<axis xyz="1 0 0"/><mimic joint="j1"/>',
        "'j4' mimics .* fixed = { \"j4\" = 0 }",
    ),
    "a planar joint": (
        '"j4" type="revolute"',
        '"j4" type="planar"',
        "'planar'.*: fixed = { \"j4\" = 0 }",
    ),
    "an axis of no length": ('xyz="1 0 0"', 'xyz="0 0 0"', "Joint 'j4' has an axis of zero length"),
    "a robot with a prefix": ("robot", "u:robot", "The outermost element is <u:robot>"),
    "an attribute twice": ('lower="-2"', 'lower="-2" lower="-1"', "not well-formed XML: duplicate attribute"),
    "a tree of another kind": ("robot", "model", "The outermost element is <model>"),
}


def same(first, second):
    """Whether two arms are equal in all that decides how they move."""
    arrays = ("lower", "upper", "max_speed", "max_acceleration", "home")
    chains = ("T_previous_joint", "axes", "T_last_tip")
    return (
        (first.joint_names, first.end_effector_link, first.chain.kinds)
        == (second.joint_names, second.end_effector_link, second.chain.kinds)
        and all(np.array_equal(getattr(first, name), getattr(second, name)) for name in arrays)
        and all(np.array_equal(getattr(first.chain, name), getattr(second.chain, name)) for name in chains)
    )


def test_end_effector_is_that_of_pinocchio(tmp_path_factory, subtests):
    """At twenty random poses, to 1e-12 m; where ROS's parser refuses the file, that of the file without its fault."""
    for name in BROUGHT:
        with subtests.test(name=name):
            robot = read_arm(tmp_path_factory.mktemp("case"), BROUGHT[name])
            poses, text = poses_of(robot), ARM if name in NOT_READ_BY_ROS else BROUGHT[name]
            assert_allclose(robot.end_effector(poses), tips_of_pinocchio(text, robot, poses), rtol=0, atol=1e-12)


def test_every_simulator_moves_what_was_read(tmp_path_factory, subtests):
    """It follows a command, and its end effector is where the kinematics have it."""
    for name in [*BROUGHT, "placeholders"]:
        for simulator in ["kinematic", "mujoco", "pybullet"]:
            with subtests.test(name=name, simulator=simulator):
                tmp_path = tmp_path_factory.mktemp("case")
                placeholders = {"placeholders": changed(('velocity="2" effort="50"', 'velocity="0" effort="0"'))}
                toml = "max_speed_deg_s = [90, 90, 90, 90]" * (name in placeholders)
                robot = read_arm(tmp_path, {**BROUGHT, **placeholders}[name], toml)
                simulation = opened(robot, simulator)
                simulation.place(robot.home[None])
                for _ in range(5):
                    state = simulation.drive(robot.home[None] + 0.05, 0.1)
                assert_allclose(state.qpos[0], robot.home + 0.05, rtol=0, atol=1e-3)
                assert_allclose(state.end_effector[0], robot.end_effector(state.qpos[0]), rtol=0, atol=1e-6)
                simulation.close()


def test_what_must_not_matter_does_not(tmp_path_factory, subtests):
    """The arm is equal, number by number, and Pinocchio agrees."""
    for name, text in ALIKE.items():
        with subtests.test(name=name):
            tmp_path = tmp_path_factory.mktemp("case")
            robot = read_arm(tmp_path, text)
            assert same(robot, read_arm(tmp_path / "plain", ARM))
            poses = poses_of(robot)
            found = tips_of_pinocchio(text, robot, poses)
            assert_allclose(robot.end_effector(poses), found, rtol=0, atol=1e-12)


def rewritten(text, rng):
    """The same arm in other words: other orders, blanks, comments, quotes, namespaces, numbers and unknown parts."""
    root = ElementTree.fromstring(text)
    for element in list(root.iter()):
        element[:] = rng.sample(list(element), len(element))
        element.attrib = dict(rng.sample(list(element.items()), len(element.attrib)))
        element.tail = rng.choice(("", " ", "\n\t", "words"))
        for name, value in element.items():
            if name in ("xyz", "rpy", "lower", "upper"):
                element.set(name, rng.choice((" ", "  ")).join(_rewritten(word, rng) for word in value.split()))
        if rng.random() < 0.2:
            element.append(ElementTree.Element(rng.choice(("note", "a:b", "Link", "Axis")), {"c:xyz": "1 2", "d": "e"}))
        if rng.random() < 0.2:
            element.append(ElementTree.Comment("<link> & so on"))
    root.tail = None
    told = ElementTree.tostring(root, encoding="unicode")
    if rng.random() < 0.3:
        told = told.replace("<robot", f'<robot {rng.choice(("xmlns", "xmlns:c", "xmlns:e"))}="http://x"', 1)
    if rng.random() < 0.3:
        told = told.replace('"', "'")
    return rng.choice(("", " \n", "\ufeff", "<?xml version='1.0' encoding='utf-8'?>", "<!-- a -->")) + told


def _rewritten(word, rng):
    number = float(word)
    return rng.choice((word, repr(number), f"{number:+.17e}", f"{number:#.17G}"))


@pytest.mark.parametrize("name", ["plain", "a jaw", "mounted on a table"])
def test_an_arm_in_other_words_is_the_same(tmp_path, name):
    """In fifty random ones; Pinocchio, which knows one word less, is asked about the first."""
    plain = read_arm(tmp_path / "plain", BROUGHT[name])
    for seed in range(50):
        told = rewritten(BROUGHT[name], Random(seed))
        assert same(read_arm(tmp_path, told), plain), told
    poses = poses_of(plain)
    found = tips_of_pinocchio(rewritten(BROUGHT[name], Random(0)), plain, poses)
    assert_allclose(plain.end_effector(poses), found, rtol=0, atol=1e-12)


def test_what_moves_an_arm_matters(tmp_path):
    """Else the comparison would find everything equal."""
    assert not same(read_arm(tmp_path, changed(('xyz="0 1 0"', 'xyz="0 1 1e-9"'))), read_arm(tmp_path / "b", ARM))
    assert not same(read_arm(tmp_path, changed(('lower="-2"', 'lower="-1"'))), read_arm(tmp_path / "b", ARM))


def test_a_comment_before_the_declaration_is_read(tmp_path):
    """As people put their licence there."""
    assert same(read_arm(tmp_path, "<!-- (c) <?xml -->\n<!--->-->" + ARM), read_arm(tmp_path / "plain", ARM))


@pytest.mark.parametrize("more", ['<limit lower="" upper="x"/>', '<mimic joint="j1"/>', '<axis xyz="0 0 0"/>', LIMIT])
def test_joints_beside_the_chain_are_not_judged(tmp_path, more):
    """A finger that nothing moves may have any limits, an axis without a direction, or mimic another one."""
    plain = read_arm(tmp_path / "plain", changed(("</robot>", BESIDE.format(""))))
    robot = read_arm(tmp_path, changed(("</robot>", BESIDE.format(more))))
    assert same(robot, plain)
    assert robot.urdf.count('type="fixed"') == 3


@pytest.mark.parametrize("more", ['<dynamics damping="x" friction=""/>', '<safety_controller soft_lower_limit=""/>'])
def test_words_that_nothing_uses_do_not_reach_engines(tmp_path, more):
    """An engine would stop at them."""
    robot = read_arm(tmp_path, in_joint("j2", more))
    assert same(robot, read_arm(tmp_path / "plain", ARM))
    assert more.partition(" ")[0] not in robot.urdf


def test_range_of_a_continuous_joint_is_not_judged(tmp_path):
    """It has none."""
    text = changed(('type="revolute"', 'type="continuous"'), ('lower="-2" upper="2"', 'lower="" upper="x"'))
    robot = read_arm(tmp_path, text)
    assert robot.lower.tolist() == [-np.pi] * 4
    assert "upper" not in robot.urdf


def test_what_cannot_be_read_is_refused_in_one_line(tmp_path_factory, subtests):
    """The file, what is wrong, and what to do."""
    for name, (old, new, message) in REFUSED.items():
        with subtests.test(name=name):
            tmp_path = tmp_path_factory.mktemp("case")
            with refused(message) as caught:
                read_arm(tmp_path, changed((old, new)))
            assert str(caught.value).startswith(f"{tmp_path / 'arm.urdf'}: ")


def test_utf_16_is_refused_in_one_line(tmp_path):
    """As ROS does."""
    (tmp_path / "arm.urdf").write_bytes(ARM.encode("utf-16"))
    with refused(r"is not UTF-8 text .* Save it as UTF-8"):
        read_robot(tmp_path / "arm.urdf")


def test_what_engines_get_is_xml_to_every_parser(tmp_path_factory, subtests):
    """Also to one that knows namespaces: the tags are those of a URDF."""
    for name in [*BROUGHT, *ALIKE]:
        with subtests.test(name=name):
            root = ElementTree.fromstring(read_arm(tmp_path_factory.mktemp("case"), {**BROUGHT, **ALIKE}[name]).urdf)
            assert root.tag == "robot"
            assert len(root.findall("link")) >= 6


def test_text_with_a_declared_prefix_stays_as_it_is(tmp_path):
    """So cells that were done with such an arm go on."""
    text = changed(
        ("<robot", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"'),
        ('<link name="tool"/>', f'<link name="tool">{BODY}</link>'),
    )
    assert read_arm(tmp_path, text).urdf == text
