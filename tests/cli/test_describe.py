import re
import shutil
from pathlib import Path

import pytest

import harness_robots
from harness.reward.steps import ARM
from tests.robot.brought_arms import JAW, changed

TORN = """
from dataclasses import dataclass

@dataclass(frozen=True)
class Torn:
    def recognises(self, path, head):
        return False

    def read(self, path):
        return 1 / 0

    def write_example(self, folder):
        return folder
"""
SPEEDS = "max_speed_deg_s = [90, 90, 90, 90]"


def test_docstring_of_one_line_is_told_once(harness, tmp_path):
    """The reward of a file has it for a summary too."""
    file = tmp_path / "plain.py"
    file.write_text(
        "import dataclasses\n\n@dataclasses.dataclass(frozen=True)\nclass Plain:\n"
        '    """Pays nothing at all."""\n\n    def initial_carry(self, begin_distance):\n        return ()\n\n'
        "    def __call__(self, carry, sample):\n        return carry, 0.0 * sample.distance\n"
    )
    assert harness("describe plain --plugin", file).out.count("Pays nothing at all.") == 1


def test_robot_of_a_path_is_described(harness, tmp_path):
    """A URDF anywhere is described with its joints, home, and where the numbers come from."""
    shutil.copy(Path(harness_robots.UNITY_ARM, "unity_arm.urdf"), tmp_path / "mine.urdf")
    out = harness("describe", tmp_path / "mine.urdf").out
    assert "robot mine: 5 joints, end effector Axis06Tip" in out
    assert re.search(r"home: +a pose in front of the mount", out)
    assert re.search(r"home: +robot\.toml", harness("describe unity-arm").out)


def test_a_folder_beside_needs_no_slash(harness, tmp_path, monkeypatch):
    """As for `harness run`; a registered robot of that name comes first."""
    for name in ("my arm", "unity-arm"):
        shutil.copytree(Path(harness_robots.FD100), tmp_path / name)
    monkeypatch.chdir(tmp_path)
    assert "robot fd100: 6 joints" in harness("describe 'my arm'").out
    assert "robot fd100: 6 joints" in harness("describe --robot 'my arm'").out
    assert "robot unity-arm: 5 joints" in harness("describe unity-arm").out


def test_an_arm_with_a_jaw_is_described_with_what_to_write(harness, tmp_path):
    """A run tells it too, before anything is trained, and the line is not cut."""
    path = tmp_path / "arm.urdf"
    path.write_text(JAW)
    note = 'robot.toml: end_effector = "tcp"\n'
    assert note in harness("describe", path).out
    answer = harness("run --sim kinematic --algo random --robot", path, "--dry-run")
    assert note in answer.err
    assert "the end effector, 'jaw', is moved by 'gripper'" in answer.err


def test_the_tip_of_an_arm_is_described_with_what_else_might_be_meant(harness, tmp_path):
    """The link, the joint that cannot move it, the links beside it, and the line for the tool's frame among them."""
    tool = '<link name="tcp"/><joint name="k" type="fixed"><parent link="tool"/><child link="tcp"/></joint>'
    (tmp_path / "arm.urdf").write_text(changed(("</robot>", f"{tool}</robot>")))
    (tmp_path / "robot.toml").write_text('end_effector = "l4"')
    out = harness("describe", tmp_path / "arm.urdf").out
    assert (
        "\n\nTargets are for the origin of link l4.\nIt lies on the axis of j4, which cannot move it.\n"
        'Links beside it: tcp, tool.\nIf the tool is meant, write into robot.toml: end_effector = "tcp"\n\n'
    ) in out
    (tmp_path / "robot.toml").write_text('end_effector = "tcp"')
    out = harness("describe", tmp_path / "arm.urdf").out
    assert "Targets are for the origin of link tcp.\nLinks beside it: l4, tool.\n\n" in out


def test_speeds_that_are_missing_are_told_whole(harness, tmp_path):
    """What to write is not cut either, and then the arm is described."""
    path = tmp_path / "arm.urdf"
    path.write_text(changed(('velocity="2" effort="50"', 'velocity="0" effort="0"')))
    answer = harness("describe", path)
    assert answer.status == 2
    assert answer.err.endswith(f"{tmp_path / 'robot.toml'}, with the arm's own numbers: {SPEEDS}\n")
    (tmp_path / "robot.toml").write_text(SPEEDS)
    assert re.search(r"max speed: +robot\.toml", harness("describe", path).out)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "No robot at"),
        ("<robot", "The URDF is not well-formed XML"),
        ("<mujoco/>", "Nothing in it turns or slides by a joint. Give the MJCF of an arm"),
        ("<machine/>", "The outermost element is <machine>, a URDF's is <robot>"),
    ],
)
def test_what_is_no_urdf_is_refused(harness, tmp_path, text, message):
    """One line with the path, and status 2."""
    path = tmp_path / "mine.urdf"
    if text is not None:
        path.write_text(text)
    answer = harness("describe", path)
    assert answer.status == 2
    assert message in answer.err
    assert str(path) in answer.err
    assert answer.err.count("\n") == 1


def test_a_robots_drives_are_described(harness, tmp_path):
    """Or that there are none."""
    shutil.copy(Path(harness_robots.__path__[0]) / "fd100" / "fd100.urdf", tmp_path / "arm.urdf")
    assert "No drives for drive=servo" in harness("describe", str(tmp_path / "arm.urdf")).out


GENTLE = '''
def gentle(step):
    """Reach the target, and move little."""
    return {"reach": -step.distance, "jerk": -0.1 * ((step.action - step.before.action) ** 2).sum(-1)}
'''


def test_a_reward_tells_what_it_reads_and_could_read(harness, tmp_path):
    """Found by a call; its terms are its parameters."""
    (tmp_path / "gentle.py").write_text(GENTLE)
    out = harness("describe gentle --plugin", str(tmp_path / "gentle.py")).out
    assert (
        "It pays the sum of its terms: reach, jerk.\nIt reads step.action, step.before.action, step.distance.\n" in out
    )
    for field in ARM:
        assert re.search(rf"^  {field.name} +{re.escape(f'{field.shape} {field.unit}'.strip())} ", out, re.MULTILINE)
    assert re.search(r"^  jerk +float +1\.0 +weight of the term", out, re.MULTILINE)


def test_a_field_that_is_not_there_is_refused_by_its_name(harness, tmp_path):
    """Before anything runs, with the nearest one."""
    (tmp_path / "gentle.py").write_text(GENTLE.replace("step.distance", "step.joint_speed"))
    answer = harness("describe gentle --plugin", str(tmp_path / "gentle.py"))
    assert (answer.status, answer.out) == (2, "")
    assert "has no 'joint_speed'. It has: begin_distance" in answer.err
    assert "Did you mean 'qvel'?" in answer.err


def test_a_reward_of_environments_is_told_apart(harness, tmp_path):
    """It reads what no arm has."""
    (tmp_path / "calm.py").write_text("def calm(step):\n    return -abs(step.observation[2])\n")
    answer = harness("describe calm --plugin", str(tmp_path / "calm.py"))
    assert answer.status == 0
    assert "It reads step.observation: it pays steps of environments, and no arm." in answer.out


def test_a_log_format_that_cannot_read_its_example_is_described_without_it(harness, tmp_path):
    """And says why."""
    (tmp_path / "torn.py").write_text(TORN)
    answer = harness("describe torn --plugin", str(tmp_path / "torn.py"))
    assert answer.status == 0
    assert "What it reads is not known: Log format 'torn' of package torn.py" in answer.out
    assert "raised ZeroDivisionError: division by zero while its example was read" in answer.out
