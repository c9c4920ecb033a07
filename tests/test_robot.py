"""Reading a robot's folder."""

from dataclasses import FrozenInstanceError
from pathlib import Path

import numpy as np
import pytest

from harness.errors import UsageError
from harness.robot import read_robot

URDF = """
<robot name="arm">
  <link name="base"/> <link name="upper"/> <link name="lower"/> <link name="tip"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/> <child link="upper"/> <origin xyz="0 0 5"/> <axis xyz="0 0 1"/>
    <limit lower="-1" upper="2" velocity="1.5707963267948966" effort="1"/>
  </joint>
  <joint name="elbow" type="continuous">
    <parent link="upper"/> <child link="lower"/> <origin xyz="0.5 0 0"/> <axis xyz="0 0 1"/>
  </joint>
  <joint name="mount" type="fixed"> <parent link="lower"/> <child link="tip"/> <origin xyz="0.25 0 0"/> </joint>
</robot>
"""
TOML = """
name = "arm"
urdf = "arm.urdf"
end_effector = "tip"
home_deg = [0, 90]
max_speed_deg_s = [90, 180.0]
max_acceleration_deg_s2 = [360, 720]
"""


def _write(folder: Path, toml: str = TOML, urdf: str = URDF) -> Path:
    (folder / "robot.toml").write_text(toml, encoding="utf-8")
    (folder / "arm.urdf").write_text(urdf, encoding="utf-8")
    return folder


def test_robot_is_what_the_folder_says(tmp_path: Path):
    """Names, text and folder are those of the files; angles are turned from degrees into radians."""
    robot = read_robot(_write(tmp_path))
    assert (robot.name, robot.end_effector_link, robot.joint_names) == ("arm", "tip", ("shoulder", "elbow"))
    assert (robot.urdf, robot.folder, robot.dof) == (URDF, tmp_path, 2)
    np.testing.assert_allclose(robot.home, [0.0, np.pi / 2])
    np.testing.assert_allclose(robot.max_speed, [np.pi / 2, np.pi])
    np.testing.assert_allclose(robot.max_acceleration, [2 * np.pi, 4 * np.pi])


def test_continuous_joint_ranges_over_one_turn(tmp_path: Path):
    """Every limit is finite: a joint without limits has -pi to pi."""
    robot = read_robot(_write(tmp_path))
    assert robot.lower.tolist() == [-1.0, -np.pi]
    assert robot.upper.tolist() == [2.0, np.pi]


def test_robot_cannot_be_changed(tmp_path: Path):
    """Neither a field nor an entry of an array can be written to."""
    robot = read_robot(_write(tmp_path))
    for array in (robot.lower, robot.upper, robot.max_speed, robot.max_acceleration, robot.home):
        assert (array.dtype, array.shape) == (np.float64, (2,))
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0
    with pytest.raises(FrozenInstanceError):
        robot.name = "other"  # type: ignore[misc]


def test_end_effector_and_jacobian_by_hand(tmp_path: Path):
    """With the elbow at a right angle the tip is at (0.5, 0.25, 5); the shoulder moves it along (-0.25, 0.5, 0)."""
    robot = read_robot(_write(tmp_path))
    np.testing.assert_allclose(robot.end_effector(robot.home), [0.5, 0.25, 5.0], atol=1e-15)
    jacobian = robot.jacobian(robot.home)
    np.testing.assert_allclose(jacobian, [[-0.25, -0.25], [0.5, 0.0], [0.0, 0.0]], atol=1e-15)


def test_reach_is_the_chain_stretched_out(tmp_path: Path):
    """The reach is 0.5 m + 0.25 m, whatever the height the arm stands at; the stretched arm attains it."""
    robot = read_robot(_write(tmp_path))
    assert robot.reach == pytest.approx(0.75)
    assert np.linalg.norm(robot.end_effector([0.3, 0.0]) - [0.0, 0.0, 5.0]) == pytest.approx(robot.reach)


def test_wrong_shape_is_refused(tmp_path: Path):
    """Joint positions of another robot are answered with both shapes."""
    robot = read_robot(_write(tmp_path))
    for compute in (robot.end_effector, robot.jacobian):
        with pytest.raises(UsageError, match=r"qpos has shape \(7, 3\), allowed is \(\.\.\., 2\)"):
            compute(np.zeros((7, 3)))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name = "arm"', "name = arm", "robot.toml: not well-formed TOML"),
        ('name = "arm"', "", "robot.toml: missing name. Give exactly the keys name, urdf, end_effector, home_deg, "),
        ('name = "arm"', 'colour = "red"\nname = "arm"', "robot.toml: unknown colour. Give exactly the keys"),
        ('name = "arm"', "name = 5", "robot.toml: name is 5. Give a text"),
        ('"tip"', '""', "robot.toml: end_effector is ''. Give a text"),
        ('"tip"', '"hand"', "arm.urdf: No link 'hand' in the URDF."),
        ("arm.urdf", "leg.urdf", r"leg.urdf: cannot be read \(No such file or directory\)"),
        ("[0, 90]", "90", "robot.toml: home_deg is 90. Give a list of 2 finite numbers"),
        ("[0, 90]", '[0, "90"]', r"robot.toml: home_deg is \[0, '90'\]. Give a list of 2 finite numbers"),
        ("[0, 90]", "[0, true]", "Give a list of 2 finite numbers"),
        ("[0, 90]", "[0, nan]", "Give a list of 2 finite numbers"),
        ("[0, 90]", "[0, 90, 0]", "robot.toml: home_deg has 3 values for 2 driven joints."),
        ("[90, 180.0]", "[90]", "robot.toml: max_speed_deg_s has 1 values for 2 driven joints."),
        ("[360, 720]", "[]", "robot.toml: max_acceleration_deg_s2 has 0 values for 2 driven joints."),
        ("[0, 90]", "[120, 90]", "robot.toml: home_deg of 'shoulder' is 120; allowed: -57.2958 to 114.592."),
        ("[0, 90]", "[0, -181]", "robot.toml: home_deg of 'elbow' is -181; allowed: -180 to 180."),
        ("[90, 180.0]", "[90, 0]", "robot.toml: max_speed_deg_s of 'elbow' is 0. Give a positive value."),
        ("[360, 720]", "[-1, 720]", "robot.toml: max_acceleration_deg_s2 of 'shoulder' is -1. Give a positive value."),
        ("[90, 180.0]", "[91, 180]", "robot.toml: max_speed_deg_s of 'shoulder' is 91; the URDF allows 90."),
    ],
)
def test_bad_settings_are_refused_in_one_line(tmp_path: Path, old: str, new: str, message: str):
    """Each fault of robot.toml is a UsageError of one line that starts with the file."""
    toml = TOML.replace(old, new)
    assert toml != TOML
    with pytest.raises(UsageError, match=message) as caught:
        read_robot(_write(tmp_path, toml=toml))
    assert str(caught.value).startswith(str(tmp_path))
    assert "\n" not in str(caught.value)


def test_fault_of_the_urdf_names_the_file(tmp_path: Path):
    """What the URDF's reader refuses is passed on with the file in front."""
    with pytest.raises(UsageError, match=r"arm\.urdf: Joint 'shoulder' has the limits 3 to 2\."):
        read_robot(_write(tmp_path, urdf=URDF.replace('lower="-1"', 'lower="3"')))


def test_sliding_joint_is_refused(tmp_path: Path):
    """robot.toml is in degrees, so a robot's driven joints turn."""
    urdf = URDF.replace('type="revolute"', 'type="prismatic"')
    with pytest.raises(UsageError, match=r"arm\.urdf: driven joint 'shoulder' is prismatic\."):
        read_robot(_write(tmp_path, urdf=urdf))


def test_folder_without_robot_is_refused(tmp_path: Path):
    """A folder that holds no robot.toml is no robot, nor is a file."""
    with pytest.raises(UsageError, match=r"robot\.toml: cannot be read \(No such file or directory\)"):
        read_robot(tmp_path)
    with pytest.raises(UsageError, match=r"robot\.toml: cannot be read \(Not a directory\)"):
        read_robot(_write(tmp_path) / "arm.urdf")


def test_file_in_another_encoding_is_refused(tmp_path: Path):
    """Bytes that are no UTF-8 are answered with the file's name."""
    (_write(tmp_path) / "robot.toml").write_bytes(b'name = "\xff"')
    with pytest.raises(UsageError, match=r"robot\.toml: is not UTF-8 text"):
        read_robot(tmp_path)
