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


def test_the_task_is_described_as_the_tuple(harness):
    """`describe fd100-reach` has S with Table I's numbers of every joint, A, T and R."""
    out = harness("describe", "fd100-reach").out
    for text in (
        "S, the state: 28 numbers",
        "A, the actions: MoveJ",
        "T, the transition",
        "R, the reward",
        "s_j6-accel",
    ):
        assert text in out


def test_the_task_explains_where_it_differs_from_the_note(harness):
    """Who picks the baseline's own task reads that a touched target does not end the episode, as NOTE eq. 19 has it."""
    out = harness("describe", "unity-reach").out
    assert "next target" in out
    assert "NOTE eq. 19 differs: +1, and the episode ends" in out
    assert "S, the state: 19 numbers" in out


def test_a_task_with_a_goal_tells_its_error(harness):
    """By name, unit and tolerance, and what else the learner sees."""
    out = harness("describe", "fd100-pose").out
    assert "the pose error is at most epsilon = 0.02 m" in out
    assert "S, the state: 37 numbers" in out
    assert re.search(r"goal +9 numbers +the target's x and y axis", out)
    assert "the distance is at most epsilon = 0.05 m for 10 steps in a row" in harness("describe", "fd100-moving").out


def test_overrides_show_in_the_description(harness):
    """A description is that of the parameters given."""
    assert "epsilon = 0.02 m" in harness("describe", "fd100-reach:epsilon=0.02").out


def test_whatever_is_listed_can_be_described(harness, subtests: pytest.Subtests):
    """Every kind of name has a description."""
    for name in ["arp", "baseline", "mujoco", "fd100", "success_rate", "processes"]:
        with subtests.test(name=name):
            answer = harness("describe", name)
            assert answer.status == 0
            assert name in answer.out


def test_the_reward_explains_the_contradiction_of_its_sources(harness):
    """Who picks ARP reads which settings were published."""
    out = harness("describe", "arp").out
    assert "k1 = 1, k2 = 2" in out
    assert "1.5" in out


def test_names_of_sources_are_explained_where_they_stand(harness):
    """`arp` cites both; `random` cites none."""
    assert harness("describe", "arp").out.endswith("NOTE and ARP are the sources that docs/sources.md names.\n")
    assert "docs/sources.md" not in harness("describe", "random").out


def test_docstring_of_one_line_is_told_once(harness, tmp_path):
    """The reward of a file has it for a summary too."""
    file = tmp_path / "plain.py"
    file.write_text(
        "import dataclasses\n\n@dataclasses.dataclass(frozen=True)\nclass Plain:\n"
        '    """Pays nothing at all."""\n\n    def initial_carry(self, begin_distance):\n        return ()\n\n'
        "    def __call__(self, carry, sample):\n        return carry, 0.0 * sample.distance\n"
    )
    assert harness("describe", "plain", "--plugin", file).out.count("Pays nothing at all.") == 1


def test_robot_of_a_path_is_described(harness, tmp_path):
    """A URDF anywhere is described with its joints, home, and where the numbers come from."""
    shutil.copy(Path(harness_robots.UNITY_ARM, "unity_arm.urdf"), tmp_path / "mine.urdf")
    out = harness("describe", tmp_path / "mine.urdf").out
    assert "robot mine: 5 joints, end effector Axis06Tip" in out
    assert re.search(r"home: +a pose in front of the mount", out)
    assert re.search(r"home: +robot\.toml", harness("describe", "unity-arm").out)


def test_a_folder_beside_needs_no_slash(harness, tmp_path, monkeypatch):
    """As for `harness run`; a registered robot of that name comes first."""
    for name in ("my arm", "unity-arm"):
        shutil.copytree(Path(harness_robots.FD100), tmp_path / name)
    monkeypatch.chdir(tmp_path)
    assert "robot fd100: 6 joints" in harness("describe", "my arm").out
    assert "robot fd100: 6 joints" in harness("describe", "--robot", "my arm").out
    assert "robot unity-arm: 5 joints" in harness("describe", "unity-arm").out


def test_robot_alone_is_described_itself(harness, tmp_path):
    """`--robot FILE` is as good as `FILE`."""
    shutil.copy(Path(harness_robots.UNITY_ARM, "unity_arm.urdf"), tmp_path / "mine.urdf")
    assert harness("describe", "--robot", tmp_path / "mine.urdf").out == harness("describe", tmp_path / "mine.urdf").out


def test_an_arm_with_a_jaw_is_described_with_what_to_write(harness, tmp_path):
    """A run tells it too, before anything is trained, and the line is not cut."""
    path = tmp_path / "arm.urdf"
    path.write_text(JAW)
    note = 'robot.toml: end_effector = "tcp"\n'
    assert note in harness("describe", path).out
    answer = harness("run", "--sim", "kinematic", "--algo", "random", "--robot", path, "--dry-run")
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


def test_unknown_names_are_refused(harness):
    """A wrong name ends with status 2 and the nearest match."""
    answer = harness("describe", "fd100-reech")
    assert answer.status == 2
    assert "Did you mean 'fd100-reach'?" in answer.err


def test_a_robots_drives_are_described(harness, tmp_path):
    """Their numbers, by joint; or that there are none."""
    out = harness("describe", "fd100").out
    assert re.search(r"joint2 +800 +10 +25 +25 +29000 +1920\n", out)
    assert "latency 0.01 s, weight compensated" in out
    shutil.copy(Path(harness_robots.__path__[0]) / "fd100" / "fd100.urdf", tmp_path / "arm.urdf")
    assert "No drives for drive=servo" in harness("describe", str(tmp_path / "arm.urdf")).out


def test_what_cannot_be_made_without_a_parameter_is_described(harness):
    """The parameter says that it has to be given, and the others what they are by default."""
    answer = harness("describe", "gymnasium")
    assert answer.status == 0
    (row,) = [line for line in answer.out.splitlines() if line.split()[:1] == ["id"]]
    assert "has to be given" in row
    assert "made_with" in answer.out


def test_another_parameter_alone_is_not_enough(harness):
    """Status 2, one line that names the one that is missing."""
    answer = harness("describe", "gymnasium:pays=reward_ctrl")
    assert (answer.status, answer.out) == (2, "")
    assert "id has to be given" in answer.err


def test_an_algorithm_tells_what_it_is_in_an_environment(harness):
    """Where a default differs there; nothing where the user chose, or where none differs."""
    assert "In an environment, ppo stands for ppo:gamma=0.99." in harness("describe", "ppo").out
    for name in ("ppo:gamma=0.9", "ppo:preset=unity", "random"):
        assert "In an environment" not in harness("describe", name).out


GENTLE = '''
def gentle(step):
    """Reach the target, and move little."""
    return {"reach": -step.distance, "jerk": -0.1 * ((step.action - step.before.action) ** 2).sum(-1)}
'''


def test_a_reward_tells_what_it_reads_and_could_read(harness, tmp_path):
    """Found by a call; its terms are its parameters."""
    (tmp_path / "gentle.py").write_text(GENTLE)
    out = harness("describe", "gentle", "--plugin", str(tmp_path / "gentle.py")).out
    assert (
        "It pays the sum of its terms: reach, jerk.\nIt reads step.action, step.before.action, step.distance.\n" in out
    )
    for field in ARM:
        assert re.search(rf"^  {field.name} +{re.escape(f'{field.shape} {field.unit}'.strip())} ", out, re.MULTILINE)
    assert re.search(r"^  jerk +float +1\.0 +weight of the term", out, re.MULTILINE)


def test_a_field_that_is_not_there_is_refused_by_its_name(harness, tmp_path):
    """Before anything runs, with the nearest one."""
    (tmp_path / "gentle.py").write_text(GENTLE.replace("step.distance", "step.joint_speed"))
    answer = harness("describe", "gentle", "--plugin", str(tmp_path / "gentle.py"))
    assert (answer.status, answer.out) == (2, "")
    assert "has no 'joint_speed'. It has: begin_distance" in answer.err
    assert "Did you mean 'qvel'?" in answer.err


def test_a_reward_of_environments_is_told_apart(harness, tmp_path):
    """It reads what no arm has."""
    (tmp_path / "calm.py").write_text("def calm(step):\n    return -abs(step.observation[2])\n")
    answer = harness("describe", "calm", "--plugin", str(tmp_path / "calm.py"))
    assert answer.status == 0
    assert "It reads step.observation: it pays steps of environments, and no arm." in answer.out


def test_an_environment_tells_what_a_step_of_it_has(harness):
    """One env is made and stepped once."""
    out = harness("describe", "gymnasium:id=CartPole-v1").out
    assert re.search(r"^  observation +Box\(.*\(4,\), float32\) +what the env observed", out, re.MULTILINE)
    assert re.search(r"^  action +Discrete\(2\) +what the policy did", out, re.MULTILINE)


def test_an_environment_that_cannot_be_made_is_described_without_it(harness):
    """And says why."""
    answer = harness("describe", "gymnasium:id=No-Such-v0")
    assert answer.status == 0
    assert "What a reward may read is not known: gymnasium.make('No-Such-v0') fails" in answer.out


def test_a_log_format_tells_what_its_rows_are(harness):
    """By the log that it writes as an example."""
    out = harness("describe", "monitor").out
    assert "log format monitor: " in out
    assert re.search(r"^A row is an episode\. Its example has the columns reward/recorded, ", out, re.MULTILINE)


def test_a_log_format_that_cannot_read_its_example_is_described_without_it(harness, tmp_path):
    """And says why."""
    (tmp_path / "torn.py").write_text(TORN)
    answer = harness("describe", "torn", "--plugin", str(tmp_path / "torn.py"))
    assert answer.status == 0
    assert "What it reads is not known: Log format 'torn' of package torn.py" in answer.out
    assert "raised ZeroDivisionError: division by zero while its example was read" in answer.out
