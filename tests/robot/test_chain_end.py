"""Where the chain of an arm ends that does not name its end effector."""

import pytest

from harness.robot import parse_urdf
from harness.robot.chain_end import Tip, find_chain_end, tip_of
from tests.refusals import refused
from tests.robot.brought_arms import ARM, JAW, changed, read_arm


def arm(*joints):
    """A URDF of joints written as ``parent-child``, or ``parent>child`` where the joint moves."""
    links, text = set(), ""
    for joint in joints:
        kind = "revolute" if ">" in joint else "fixed"
        parent, child = joint.replace(">", "-").split("-")
        links |= {parent, child}
        text += f'<joint name="{parent}-{child}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        text += '<limit lower="0" upper="1"/></joint>'
    named = "".join(f'<link name="{link}"/>' for link in sorted(links))
    return parse_urdf(f'<robot name="r">{named}{text}</robot>')


def test_tip_is_where_one_chain_ends(subtests):
    """The last link of a single chain, the palm of a hand; frames fixed beside the way do not count."""
    for joints, tip in [
        (("a>b", "b>c", "c>d"), "d"),
        (("a>b", "b>c", "c>d", "d-e", "e-f"), "f"),
        (("a-world", "a>b", "b>c", "c>d", "d-e"), "e"),
        (("a>b", "b-camera", "b>c", "c>d"), "d"),
        (("a>b", "b>c", "c>d", "d-flange", "d-camera"), "d"),
        (("a>b", "b>c", "c>d", "d-hand", "hand>left", "hand>right", "hand-grasp"), "grasp"),
        (("a>b", "b>c", "c>d", "d-hand", "hand-palm", "palm>one", "one>two", "palm>three"), "palm"),
        (("a>b", "b>c", "c>d", "d-left", "left>x", "d-right", "right>y"), "d"),
    ]:
        with subtests.test(joints=joints):
            assert find_chain_end(arm(*joints)) == tip
            assert find_chain_end(arm(*reversed(joints))) == tip


def test_early_branches_may_be_arms():
    """A body with two arms has no end; the answer names the branches and what to do."""
    two_arms = arm("a>body", "body>b", "b>c", "c>d", "body>x", "x>y", "y>z")
    with refused(r"branches at link 'body' into 'b', 'x'.*end_effector in a robot\.toml"):
        find_chain_end(two_arms)


def with_frames(*frames):
    """The plain arm with more links that are fixed to its last one, ``(name, xyz)``, in front of its tool."""
    more = "".join(
        f'<link name="{name}"/><joint name="to {name}" type="fixed"><parent link="l4"/><child link="{name}"/>'
        f'<origin xyz="{xyz}"/></joint>'
        for name, xyz in frames
    )
    return changed(("</robot>", f"{more}</robot>"), ('"tool"', '"flange"'))


@pytest.mark.parametrize(
    ("frames", "tip"),
    [
        ([("camera", "0 0 0.1")], "l4"),
        ([("camera", "0 0 0.1"), ("left_tcp", "0 0 0.2")], "left_tcp"),
        ([("grasp_center", "0 0 0.2"), ("plate", "0 0 0.2")], "grasp_center"),
        ([("ee_link", "0 0.08 0"), ("tool0", "0 0.08 0")], "tool0"),
        ([("tool0", "0 0.08 0"), ("ee_link", "0 0.08 0")], "tool0"),
        ([("ee_link", "0 0.08 0"), ("tool0", "0 0.09 0")], "l4"),
    ],
)
def test_of_fixed_frames_the_tools_is_the_end(frames, tip):
    """By its name, where one has such a name, or several that are at one point."""
    assert find_chain_end(parse_urdf(with_frames(*frames))) == tip


def tip(robot):
    """What is known of a robot's end effector."""
    return tip_of(robot.urdf, robot.end_effector_link, robot.chain)


def test_a_tools_frame_is_proposed_where_another_link_is_the_tip(tmp_path):
    """And what is written then makes it the tip, which has nothing to propose."""
    text = with_frames(("tool0", "0 0 0.2"), ("camera", "0 0.1 0"))
    named = read_arm(tmp_path, text, 'end_effector = "flange"')
    assert tip(named) == Tip(still=(), beside=("tool0", "l4", "camera"), tool="tool0")
    written = read_arm(tmp_path, text, 'end_effector = "tool0"')
    assert tip(written).tool is None
    assert set(tip(written).beside) == {"flange", "l4", "camera"}


def test_joints_that_cannot_move_the_tip_are_told(tmp_path):
    """A jaw, or a wrist on whose axis it lies; with the tip aside of the axis all joints do."""
    assert tip(read_arm(tmp_path / "jaw", JAW)).still == ("gripper",)
    assert tip(read_arm(tmp_path / "wrist", ARM, 'end_effector = "l4"')).still == ("j4",)
    assert tip(read_arm(tmp_path / "tool", ARM)).still == ()
