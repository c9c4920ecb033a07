"""Reading the serial chain of a URDF."""

import math
import re

import pytest

from harness.robot import parse_urdf
from harness.robot.urdf import Joint, read_chain
from tests.refusals import refused

ARM = """
<robot name="arm">
  <link name="base"/> <link name="upper"/> <link name="lower"/> <link name="slider"/> <link name="tip"/>
  <link name="finger"/>
  <joint name="turn" type="continuous">
    <parent link="base"/> <child link="upper"/>
    <origin xyz="0.1 -0.2 0.3" rpy="0.4 0.5 0.6"/> <axis xyz="0 3 4"/>
  </joint>
  <joint name="bend" type="revolute">
    <parent link="upper"/> <child link="lower"/>
    <axis xyz="0 0 -2"/> <limit lower="-1.5" upper="2" velocity="3" effort="9"/>
  </joint>
  <joint name="slide" type="prismatic">
    <parent link="lower"/> <child link="slider"/> <limit lower="0" upper="0.25"/>
  </joint>
  <joint name="mount" type="fixed">
    <parent link="slider"/> <child link="tip"/> <origin xyz="0 0 1"/>
  </joint>
  <joint name="grip" type="planar"> <parent link="slider"/> <child link="finger"/> </joint>
</robot>
"""
BEND = '<axis xyz="0 0 -2"/> <limit lower="-1.5" upper="2" velocity="3" effort="9"/>'


def chain_of(text, tip):
    """The chain of a URDF that is given as text."""
    return read_chain(parse_urdf(text), tip)


def test_chain_runs_from_root_to_tip():
    """The chain holds the joints between the root link and the tip, in that order, and no branch beside them."""
    chain = chain_of(ARM, "tip")
    assert [joint.name for joint in chain] == ["turn", "bend", "slide", "mount"]
    assert [joint.kind for joint in chain] == ["continuous", "revolute", "prismatic", "fixed"]
    assert [(joint.parent, joint.child) for joint in chain] == [
        ("base", "upper"),
        ("upper", "lower"),
        ("lower", "slider"),
        ("slider", "tip"),
    ]


def test_chain_may_end_before_the_last_link():
    """A tip in the middle of the tree ends the chain there."""
    assert [joint.name for joint in chain_of(ARM, "lower")] == ["turn", "bend"]


def test_order_in_the_file_does_not_matter():
    """Joints listed from the tip to the root give the same chain."""
    joints = re.findall(r"<joint.*?</joint>", ARM, re.DOTALL)
    body = ARM.replace("</robot>", "")
    for joint in joints:
        body = body.replace(joint, "")
    assert chain_of(body + "".join(reversed(joints)) + "</robot>", "tip") == chain_of(ARM, "tip")


def test_numbers_are_those_of_the_file():
    """Origin, limits and velocity are read as written, the axis is scaled to length 1."""
    turn, bend, _, _ = chain_of(ARM, "tip")
    assert turn == Joint(
        name="turn",
        kind="continuous",
        parent="base",
        child="upper",
        xyz=(0.1, -0.2, 0.3),
        rpy=(0.4, 0.5, 0.6),
        axis=(0.0, 0.6, 0.8),
        lower=-math.inf,
        upper=math.inf,
        velocity=None,
    )
    assert (bend.axis, bend.lower, bend.upper, bend.velocity) == ((0.0, 0.0, -1.0), -1.5, 2.0, 3.0)


def test_defaults_are_those_of_the_urdf_reference():
    """A joint without origin and axis stands in its parent's frame and moves along or about x."""
    slide = chain_of(ARM, "tip")[2]
    assert (slide.xyz, slide.rpy, slide.axis) == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0))


def test_bad_file_is_refused_in_one_line(subtests):
    """Each fault of a URDF is a UsageError of one line that names what was given."""
    for old, new, message in [
        ("</robot>", "", "The URDF is not well-formed XML: no element found"),
        ("robot", "mujoco", "The outermost element is <mujoco>, a URDF's is <robot>."),
        ('<link name="finger"/>', '<link name="finger"/> <link/>', "A <link> of the URDF has no name."),
        ('<link name="finger"/>', '<link name="finger"/> <link name="tip"/>', "more than one link 'tip'."),
        ('"bend"', '"turn"', "more than one joint 'turn'."),
        ('<child link="finger"/>', '<child link="thumb"/>', "links that the URDF does not define: 'thumb'."),
        ('<child link="finger"/>', '<child link="lower"/>', "More than one joint carries link 'lower'."),
        ('<child link="finger"/>', "", "Joint 'grip' names no child link."),
        ('<parent link="base"/>', "", "Joint 'turn' names no parent link."),
        ('<link name="finger"/>', '<link name="finger"/> <link name="car"/>', "one root link, .*: 'base', 'car'."),
        ('<parent link="base"/>', '<parent link="tip"/>', "The joints above link 'upper' form a loop."),
        ('"tip"', '"tool"', "No link 'tip' in the URDF. .*: 'base', 'upper', 'lower', 'slider', 'tool', 'finger'."),
        ('"revolute"', '"floating"', "Joint 'bend' is of type 'floating'; allowed .*: fixed, revolute, cont"),
        ('"revolute"', '"planar"', "Joint 'bend' is of type 'planar'; allowed"),
        (' type="revolute"', "", "Joint 'bend' is of type 'None'; allowed: fixed, .*, floating. Change it."),
        ('"planar"', '"hinge"', "Joint 'grip' is of type 'hinge'; allowed"),
        (BEND, BEND + '<mimic joint="turn"/>', "Joint 'bend' mimics another one"),
        ("0 0 -2", "0 0 0", "Joint 'bend' has an axis of zero length."),
        ("0 0 -2", "0 0", "Joint 'bend' has 2 numbers in <axis xyz=...>. Give three."),
        ("0 0 -2", "0 0 z", "Joint 'bend' has 'z' where a finite number belongs."),
        ("0 0 -2", "0 0 nan", "Joint 'bend' has 'nan' where a finite number belongs."),
        (BEND, "", "Joint 'bend' is revolute and has no limits."),
        ('upper="2"', "", "Joint 'bend' is revolute and has no limits."),
        ('<limit lower="0" upper="0.25"/>', "", "Joint 'slide' is prismatic and has no limits."),
        (
            'lower="0" upper="0.25"',
            'lower="-900" upper="900"',
            "Joint 'slide' slides from -900 to 900 m, 100 m are allowed",
        ),
        ('lower="-1.5"', 'lower="2.5"', "Joint 'bend' has the limits 2.5 to 2."),
        ('lower="-1.5"', 'lower="2"', "Joint 'bend' has the limits 2 to 2."),
        ('upper="2"', 'upper="inf"', "Joint 'bend' has 'inf' where a finite number belongs."),
        ("0 0 -2", "0 0 1_0", "Joint 'bend' has '1_0' where a finite number belongs."),
        ('<axis xyz="0 0 -2"/>', "<axis/>", "Joint 'bend' has an <axis> without xyz."),
    ]:
        with subtests.test(old=old):
            urdf = ARM.replace(old, new)
            assert urdf != ARM
            with refused(message):
                chain_of(urdf, "tip")


def test_tip_without_name_is_refused():
    """An empty tip is answered with the links there are."""
    with refused("No link '' in the URDF"):
        chain_of(ARM, "")


def test_no_root_is_refused():
    """Links in one ring have no root."""
    joint = '<joint name="j" type="fixed"><parent link="a"/><child link="a"/></joint>'
    with refused("one root link, carried by no joint; found: none"):
        chain_of(f'<robot name="ring"><link name="a"/>{joint}</robot>', "a")


@pytest.mark.parametrize(
    "content", ["", "<!-- a -->", '<xacro:arm prefix="left"/>', "<xacro:macro><link/></xacro:macro>"]
)
def test_a_file_without_links_is_refused(content):
    """It may be one for xacro, whose elements are no words of a URDF."""
    with refused("has no <link>"):
        parse_urdf(f"<robot>{content}</robot>")


def test_fixed_joint_needs_no_axis():
    """Exporters write an axis of no length where there is nothing to turn about."""
    urdf = ARM.replace('<origin xyz="0 0 1"/>', '<origin xyz="0 0 1"/> <axis xyz="0 0 0"/>')
    assert urdf != ARM
    assert chain_of(urdf, "tip") == chain_of(ARM, "tip")


def test_loop_beside_the_chain_is_refused():
    """Two links that carry one another hang nowhere, and an engine would stop at them."""
    ring = "".join(
        f'<link name="{a}"/><joint name="{a}" type="fixed"><parent link="{a}"/><child link="{b}"/></joint>'
        for a, b in ("pq", "qp")
    )
    with refused("The joints above link 'p' form a loop"):
        chain_of(ARM.replace("</robot>", ring + "</robot>"), "tip")


@pytest.mark.parametrize("tip", ["base", "tool"])
def test_chain_without_motion_is_refused(tip):
    """A tip that no joint moves is refused, be it the root link or one fixed to it."""
    joint = '<joint name="j" type="fixed"><parent link="base"/><child link="tool"/></joint>'
    with refused(f"No joint moves between the root link and '{tip}'."):
        chain_of(f'<robot name="stand"><link name="base"/><link name="tool"/>{joint}</robot>', tip)


def chain(count, content=""):
    """A URDF of so many links, one on the other."""
    links = "".join(f'<link name="l{number}">{content}</link>' for number in range(count))
    joints = "".join(
        f'<joint name="j{number}" type="fixed"><parent link="l{number}"/><child link="l{number + 1}"/></joint>'
        for number in range(count - 1)
    )
    return f"<robot>{links}{joints}</robot>"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (chain(201), "The URDF has 201 links, 200 are allowed."),
        (chain(3_000), "The URDF has 3,000 links, 200 are allowed."),
        (chain(2, "<a/>" * 20_000), "more than 20,000 elements"),
        ("<robot>" + "<a>" * 100_000, "or 30 within one another"),
        ('<!DOCTYPE a [<!ENTITY a "aa"><!ENTITY b "&a;&a;">]><robot name="&b;"/>', "has a <!DOCTYPE a>"),
        ('<!DOCTYPE a SYSTEM "file:///etc/passwd"><robot/>', "has a <!DOCTYPE a>"),
        ("<robot>&a;</robot>", "not well-formed XML"),
        ("<robot>\ud800</robot>", "not well-formed XML"),
    ],
    ids=["links", "many links", "elements", "depth", "entities", "external", "unknown entity", "half a character"],
)
def test_a_text_that_is_too_much_is_refused_at_once(text, message):
    """Large, deep, or with words that it defines itself."""
    with refused(message):
        parse_urdf(text)


def test_as_many_links_as_are_allowed_are_read():
    """In a long chain, too."""
    assert len(parse_urdf(chain(200)).links) == 200
