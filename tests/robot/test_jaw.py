"""A last joint that looks like the jaw of a gripper."""

import pytest

from harness.robot.robot import read_robot
from tests.project import ROOT
from tests.robot.brought_arms import ARM, JAW, changed, read_arm


def with_last(joint, kind="revolute", beside=""):
    """The arm with one more joint at its tool, and perhaps a frame beside it."""
    text = changed(('"gripper"', f'"{joint}"'), ('"tcp"', f'"{beside or "plate"}"'), text=JAW)
    begin = text.index(f'<joint name="{joint}"')
    return text[:begin] + text[begin:].replace('"revolute"', f'"{kind}"', 1)


def test_a_jaw_is_told_with_what_to_write(tmp_path):
    """Which joint, by what it looks like one, which link is the tip, and the line that names another."""
    robot = read_arm(tmp_path, JAW)
    assert (robot.dof, robot.end_effector_link) == (5, "jaw")
    (warning,) = robot.warnings
    for part in (
        "'jaw', is moved by 'gripper'",
        "by its name",
        "the tool's frame 'tcp'",
        'end_effector = "tcp"',
    ):
        assert part in warning
    assert str(tmp_path / "robot.toml") in warning
    assert "\n" not in warning


def test_what_the_warning_says_to_write_works(tmp_path):
    """Then the jaw does not move, and nothing is told."""
    (warning,) = read_arm(tmp_path, JAW).warnings
    robot = read_arm(tmp_path, JAW, warning.rpartition("robot.toml: ")[2])
    assert (robot.dof, robot.end_effector_link, robot.warnings) == (4, "tcp", ())
    assert "gripper" not in robot.joint_names


def test_who_names_the_end_effector_is_believed(tmp_path):
    """Be it the jaw."""
    assert read_arm(tmp_path, JAW, 'end_effector = "jaw"').warnings == ()


def test_a_tool_at_a_jaw_is_told(tmp_path):
    """Who adds a tool has not said that the jaw carries it; what the warning says to write moves it to the palm."""
    tool = 'tool = { xyz_m = [0.05, 0, 0.1], name = "pen" }'
    (warning,) = read_arm(tmp_path, JAW, tool).warnings
    assert "'jaw', is moved by 'gripper'" in warning
    robot = read_arm(tmp_path, JAW, f"{warning.rpartition('robot.toml: ')[2]}\n{tool}")
    assert (robot.dof, robot.end_effector_link, robot.warnings) == (4, "pen", ())


@pytest.mark.parametrize(
    ("joint", "kind", "beside", "palm"),
    [
        ("Jaw", "revolute", "", "tool"),
        ("jointGripper", "revolute", "", "tool"),
        ("finger_joint", "prismatic", "", "tool"),
        ("j5", "revolute", "gripper_frame_link", "gripper_frame_link"),
        ("j5", "prismatic", "tool0", "tool0"),
    ],
)
def test_jaws_are_found(tmp_path, joint, kind, beside, palm):
    """By their names, or by the frame of a tool on what carries them."""
    (warning,) = read_arm(tmp_path, with_last(joint, kind, beside)).warnings
    assert warning.endswith(f'end_effector = "{palm}"')


@pytest.mark.parametrize(
    ("joint", "beside"), [("j5", ""), ("wrist_3", "camera"), ("gripper_roll", ""), ("tool_rotation", "flange")]
)
def test_a_wrist_is_no_jaw(tmp_path, joint, beside):
    """Most arms end on the axis of their last joint."""
    assert read_arm(tmp_path, with_last(joint, beside=beside)).warnings == ()


def test_a_joint_that_moves_the_tip_aside_is_no_jaw(tmp_path):
    """A finger of a robot that is a finger."""
    text = with_last("finger_low").replace("</robot>", '<link name="t"/><joint name="k" type="fixed">'
        '<parent link="jaw"/><child link="t"/><origin xyz="0.1 0 0"/></joint></robot>')  # fmt: skip
    robot = read_arm(tmp_path, text)
    assert (robot.end_effector_link, robot.warnings) == ("t", ())


def test_built_in_arms_have_none(tmp_path):
    """Nor has the plain arm."""
    assert read_arm(tmp_path, ARM).warnings == ()
    for folder in (ROOT / "robots").glob("*/"):
        if (folder / "robot.toml").exists():
            assert read_robot(folder).warnings == ()
