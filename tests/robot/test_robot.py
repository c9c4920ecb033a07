"""Reading a robot's folder."""

import hashlib
import re
import sys
from dataclasses import FrozenInstanceError, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.linalg import norm
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.robot import robot as robot_module
from harness.robot.robot import read_robot
from tests.refusals import refused
from tests.robot.test_meshes import CORNERS, binary_stl, collada

URDF = """
<robot name="arm">
  <link name="base"/> <link name="upper"/> <link name="lower"/> <link name="slider"/> <link name="tip"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/> <child link="upper"/> <origin xyz="0 0 5"/> <axis xyz="0 0 1"/>
    <limit lower="-1" upper="2" velocity="1.5707963267948966" effort="1"/>
  </joint>
  <joint name="elbow" type="continuous">
    <parent link="upper"/> <child link="lower"/> <origin xyz="0.5 0 0"/> <axis xyz="0 0 1"/>
  </joint>
  <joint name="slide" type="prismatic">
    <parent link="lower"/> <child link="slider"/> <axis xyz="0 0 1"/>
    <limit lower="-0.2" upper="0.1" velocity="0.5" effort="1"/>
  </joint>
  <joint name="mount" type="fixed"> <parent link="slider"/> <child link="tip"/> <origin xyz="0.25 0 0"/> </joint>
</robot>
"""
TOML = """
name = "arm"
urdf = "arm.urdf"
end_effector = "tip"
home_deg = [0, 90]
home_m = [0.05]
max_speed_deg_s = [90, 180.0]
max_speed_m_s = [0.25]
max_acceleration_deg_s2 = [360, 720]
max_acceleration_m_s2 = [2]
"""


def _write(folder, toml=TOML, urdf=URDF):
    (folder / "robot.toml").write_text(toml)
    (folder / "arm.urdf").write_text(urdf)
    return folder


@pytest.fixture
def robot(tmp_path):
    """The arm as these files say."""
    return read_robot(_write(tmp_path))


def test_the_whole_range_of_a_slide_counts_as_a_full_turn(robot):
    """Joints that turn count as they are, limited or not."""
    assert_allclose(robot.per_radian, [1.0, 1.0, 0.3 / (2.0 * np.pi)])
    assert robot.per_radian[0] == 1.0  # exactly, so that products with it change nothing


def test_a_slide_may_do_half_its_range_a_second(tmp_path):
    """Where the URDF allows more and robot.toml says nothing, as a turning joint may do half a turn."""
    toml = TOML.replace("max_speed_m_s = [0.25]\n", "")
    assert read_robot(_write(tmp_path, toml)).max_speed[2] == pytest.approx(0.15)
    assert read_robot(_write(tmp_path, toml, URDF.replace('velocity="0.5"', 'velocity="0.1"'))).max_speed[2] == 0.1
    assert read_robot(_write(tmp_path)).max_speed[2] == 0.25


def test_robot_is_what_the_folder_says(robot, tmp_path):
    """Names and folder are those of the files; degrees are turned into radians, metres are left."""
    assert (robot.name, robot.end_effector_link) == ("arm", "tip")
    assert (robot.joint_names, robot.folder, robot.dof) == (("shoulder", "elbow", "slide"), tmp_path, 3)
    assert_allclose(robot.home, [0.0, np.pi / 2, 0.05])
    assert_allclose(robot.max_speed, [np.pi / 2, np.pi, 0.25])
    assert_allclose(robot.max_acceleration, [2 * np.pi, 4 * np.pi, 2.0])
    assert set(robot.origins.values()) == {"robot.toml"}


def test_continuous_joint_ranges_over_one_turn(robot):
    """Every limit is finite: a joint without limits has -pi to pi."""
    assert robot.lower.tolist() == [-1.0, -np.pi, -0.2]
    assert robot.upper.tolist() == [2.0, np.pi, 0.1]


def test_robot_cannot_be_changed(tmp_path):
    """Neither a field nor an entry of an array can be written to."""
    for robot in (
        read_robot(_write(tmp_path)),
        read_robot(_write(tmp_path, toml="max_speed_deg_s = [90, 180]") / "arm.urdf"),
    ):
        for array in (robot.lower, robot.upper, robot.max_speed, robot.max_acceleration, robot.home):
            assert (array.dtype, array.shape) == (np.float64, (3,))
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 0.0
        with pytest.raises(FrozenInstanceError):
            robot.name = "other"  # type: ignore[misc]


def test_end_effector_and_jacobian_by_hand(robot):
    """With the elbow at a right angle the tip is at (0.5, 0.25, 5.05); the shoulder moves it along (-0.25, 0.5, 0)."""
    assert_allclose(robot.end_effector(robot.home), [0.5, 0.25, 5.05], atol=1e-15)
    assert_allclose(robot.jacobian(robot.home), [[-0.25, -0.25, 0.0], [0.5, 0.0, 0.0], [0.0, 0.0, 1.0]], atol=1e-15)


def test_reach_and_digest_are_computed_once(tmp_path, monkeypatch):
    """Loops over decisions ask for the reach again and again, and every cell for the digest."""
    robot, computed = read_robot(_write(tmp_path)), []
    length = robot_module.chain_length
    monkeypatch.setattr(robot_module, "chain_length", lambda *given: computed.append(1) or length(*given))
    assert robot.reach == robot.reach == length(robot.chain, robot.lower, robot.upper)
    assert computed == [1]
    assert robot.digest is robot.digest
    assert replace(robot, lower=robot.lower - 1.0).digest != robot.digest


def test_digest_is_by_content_wherever_the_files_lie(tmp_path):
    """A copy in another folder is the same robot; one with another mesh, or the mesh as another format, is not."""
    mesh = '<link name="base"><visual><geometry><mesh filename="hull.stl"/></geometry></visual></link>'
    folders = [tmp_path / name for name in ("here", "there", "edited", "renamed")]
    for folder in folders:
        folder.mkdir()
        named = mesh.replace(".stl", ".obj") if folder.name == "renamed" else mesh
        _write(folder, urdf=URDF.replace('<link name="base"/>', named))
        far = 2 if folder.name == "edited" else 1
        content = f"v 0 0 0\nv {far} 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n"
        content += "".join(
            f"vertex {corner}\n" for corner in ("0 0 0", f"{far} 0 0", "0 1 0", "0 0 0", "1 0 0", "0 0 1")
        )
        (folder / ("hull.obj" if folder.name == "renamed" else "hull.stl")).write_text(content)  # either reads it
    here, there, edited, renamed = (read_robot(folder).digest for folder in folders)
    assert here == there
    assert len({here, edited, renamed}) == 3


def test_digest_without_meshes_is_that_of_earlier_versions(robot):
    """The URDF's text counts as it stands: cells of version 0.1 go on."""
    numbers = np.stack([robot.lower, robot.upper, robot.max_speed, robot.max_acceleration, robot.home])
    parts = (robot.urdf.encode(), robot.end_effector_link.encode(), numbers.tobytes())
    assert robot.digest == hashlib.sha256(b"\0".join(parts)).hexdigest()


def test_shapes_are_those_of_the_urdf(tmp_path):
    """Links have theirs by name; a joint has those of its link, and of what is fixed to it, in the link's frame."""
    box = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
    changed = URDF
    for link in ("base", "upper", "tip"):
        changed = changed.replace(f'<link name="{link}"/>', f'<link name="{link}">{box}</link>')
    robot = read_robot(_write(tmp_path, urdf=changed))
    counts = {link: len(shapes) for link, shapes in robot.link_shapes.items()}
    assert counts == {"base": 1, "upper": 1, "lower": 0, "slider": 0, "tip": 1}
    assert [len(shapes) for shapes in robot.joint_shapes] == [1, 0, 1]
    assert_array_equal(robot.joint_shapes[2][0].T_link_shape[:3, 3], [0.25, 0.0, 0.0])


def test_reach_is_the_chain_stretched_out(robot):
    """The reach is 0.5 m + 0.25 m and the 0.2 m of the slide; the extent has the 5 m that the arm stands at."""
    assert (robot.reach, robot.extent) == pytest.approx((0.95, 5.95))
    poses = default_rng(0).uniform(robot.lower, robot.upper, (1000, 3))
    for origin, most in ((5.0, robot.reach), (0.0, robot.extent)):
        assert norm(robot.end_effector(poses) - [0.0, 0.0, origin], axis=1).max() < most


def test_wrong_shape_is_refused(robot):
    """Joint positions of another robot are answered with both shapes."""
    for compute in (robot.end_effector, robot.jacobian):
        with refused(r"qpos has shape \(7, 2\), allowed is \(\.\.\., 3\)"):
            compute(np.zeros((7, 2)))


def test_urdf_alone_is_a_robot(tmp_path):
    """Its name is the file's, its end the chain's, its speeds the URDF's where it has any."""
    urdf = URDF.replace('<axis xyz="0 0 1"/>\n  </joint>', '<axis xyz="0 0 1"/> <limit velocity="9"/>\n  </joint>')
    (_write(tmp_path, urdf=urdf) / "robot.toml").unlink()
    robot = read_robot(tmp_path / "arm.urdf")
    assert (robot.name, robot.end_effector_link) == ("arm", "tip")
    assert_allclose(robot.max_speed, [np.pi / 2, np.pi, 0.15])  # 9 rad/s and 0.5 m/s are more than the rule takes
    assert_allclose(robot.max_acceleration, 8 * robot.max_speed)
    assert ((robot.lower < robot.home) & (robot.home < robot.upper)).all()
    assert "robot.toml" not in robot.origins.values()


def test_file_beside_a_urdf_says_what_it_knows(tmp_path):
    """A robot.toml may name some values only, those of one kind of joint included; the rest follows the rules."""
    _write(tmp_path, toml='end_effector = "slider"\nhome_deg = [10, 20]\nmax_speed_deg_s = [30, 40]\n')
    robot = read_robot(tmp_path / "arm.urdf")
    assert robot.end_effector_link == "slider"
    assert_allclose(np.degrees(robot.home[:2]), [10, 20])
    assert -0.2 < robot.home[2] < 0.1
    assert_allclose(robot.max_speed, [*np.radians([30, 40]), 0.15])
    assert robot.origins["end_effector"] == "robot.toml"
    assert robot.origins["home"].startswith("robot.toml, else ")


def test_file_of_another_urdf_is_not_taken(tmp_path):
    """A robot.toml that names another URDF says nothing of this one."""
    (_write(tmp_path) / "other.urdf").write_text(URDF.replace('type="continuous"', 'type="fixed"'))
    with refused(r"other\.urdf: 2 joints move between the root link and 'tip'; allowed: 3 to 8"):
        read_robot(tmp_path / "other.urdf")


SPEED = "max_speed_deg_s = { elbow = 90 }\n"


def test_file_that_names_its_urdf_from_home_is_taken(tmp_path, monkeypatch):
    """Beside the URDF as from elsewhere; with the mark of an encoding, too, as programs on Windows write it."""
    monkeypatch.setenv("HOME", str(tmp_path.parent))
    _write(tmp_path, toml=f'\ufeffurdf = "~/{tmp_path.name}/arm.urdf"\nname = "mine"\n{SPEED}')
    assert read_robot(tmp_path / "arm.urdf").name == read_robot(tmp_path).name == "mine"


def test_meshes_start_at_the_folder_of_the_urdf(tmp_path):
    """A missing mesh is answered with the URDF, the link, the name and the place."""
    mesh = '<collision><geometry><mesh filename="tip.stl"/></geometry></collision>'
    _write(tmp_path, urdf=URDF.replace('<link name="tip"/>', f'<link name="tip">{mesh}</link>'))
    message = f"{tmp_path}/arm.urdf: Link 'tip' has the mesh 'tip.stl', and there is no file '{tmp_path}/tip.stl'"
    with refused(f"^{re.escape(message)}"):
        read_robot(tmp_path)


def test_digest_does_not_depend_on_what_is_installed(tmp_path, monkeypatch):
    """A drawing in COLLADA is left out of the URDF where nothing reads it, and of the digest everywhere."""
    shape = '<visual><geometry><mesh filename="seen.dae"/></geometry></visual>'
    solid = '<collision><geometry><mesh filename="hit.stl"/></geometry></collision>'
    (tmp_path / "seen.dae").write_text(collada(CORNERS))
    (tmp_path / "hit.stl").write_bytes(binary_stl(CORNERS))
    for parts in (shape, shape + solid):
        _write(tmp_path, urdf=URDF.replace('<link name="tip"/>', f'<link name="tip">{parts}</link>'))
        seen = read_robot(tmp_path)
        with monkeypatch.context() as patch:
            patch.setitem(sys.modules, "trimesh", None)
            unseen = read_robot(tmp_path)
        assert seen.digest == unseen.digest
        assert seen.urdf != unseen.urdf


def test_mesh_in_millimetres_is_told(tmp_path):
    """Drawn it is only strange; where it collides and moves, no pose would be above the ground. Scaled it is right."""
    (tmp_path / "part.stl").write_bytes(binary_stl(100 * CORNERS))
    given = 'a mesh 100 m long, and the arm reaches 0.95 m. If the file is in millimetres, give the <mesh> scale="0.001'
    for part, scale in (("visual", ""), ("visual", 'scale="0.001 0.001 0.001"'), ("collision", "")):
        shape = f'<{part}><geometry><mesh filename="part.stl" {scale}/></geometry></{part}>'
        _write(tmp_path, urdf=URDF.replace('<link name="lower"/>', f'<link name="lower">{shape}</link>'))
        if part == "collision":
            with refused("Link 'lower' has a collision mesh 100 m long, and the arm reaches"):
                read_robot(tmp_path)
        else:
            assert [line for line in read_robot(tmp_path).warnings if "long" in line] == (
                [] if scale else [f"link 'lower': {given} 0.001 0.001\""]
            )


def test_bad_settings_are_refused_in_one_line(tmp_path_factory, subtests):
    """Each fault of robot.toml is a UsageError of one line that names the file."""
    for old, new, message in [
        (
            'name = "arm"',
            "name = arm",
            "^Robot file '.*robot.toml' cannot be read: Invalid value .at line 2, column 8.. Give",
        ),
        ('urdf = "arm.urdf"', "", "robot.toml: missing urdf. Name the URDF's file, or give its path instead"),
        (
            'name = "arm"',
            'colour = "red"\nname = "arm"',
            "robot.toml: unknown colour. The keys are name, urdf, end_eff",
        ),
        ('name = "arm"', "name = 5", "robot.toml: name is 5. Give a text"),
        ('"tip"', '""', "robot.toml: end_effector is ''. Give a text"),
        ('"tip"', '"hand"', "arm.urdf: No link 'hand' in the URDF."),
        ("arm.urdf", "leg.urdf", r"leg.urdf: cannot be read \(No such file or directory\)"),
        ("[0, 90]", "90", "robot.toml: home_deg is 90. Give a list of 2 finite numbers, one per turning"),
        ("[0, 90]", '[0, "90"]', r"robot.toml: home_deg is \[0, '90'\]. Give a list of 2 finite numbers"),
        ("[0, 90]", "[0, true]", "Give a list of 2 finite numbers"),
        ("[0, 90]", "[0, nan]", "Give a list of 2 finite numbers"),
        ("[0, 90]", "[0, 90, 0]", "robot.toml: home_deg has 3 values for 2 turning joints. Give one per joint."),
        ("[90, 180.0]", "[90]", "robot.toml: max_speed_deg_s has 1 values for 2 turning joints."),
        ("[360, 720]", "[]", "robot.toml: max_acceleration_deg_s2 has 0 values for 2 turning joints."),
        ("[0, 90]", "[120, 90]", "robot.toml: home_deg of 'shoulder' is 120; allowed: -57.2958 to 114.592."),
        ("[0, 90]", "[0, -181]", "robot.toml: home_deg of 'elbow' is -181; allowed: -180 to 180."),
        ("[90, 180.0]", "[90, 0]", "robot.toml: max_speed_deg_s of 'elbow' is 0. Give a positive value."),
        ("[360, 720]", "[-1, 720]", "robot.toml: max_acceleration_deg_s2 of 'shoulder' is -1. Give a positive value."),
        ("[0.05]", "[0.2]", "robot.toml: home_m of 'slide' is 0.2; allowed: -0.2 to 0.1."),
        ("[0.05]", "[0.05, 0]", "robot.toml: home_m has 2 values for 1 sliding joints."),
        ("[2]", "[0]", "robot.toml: max_acceleration_m_s2 of 'slide' is 0. Give a positive value."),
        ('"tip"', '"lower"', "arm.urdf: 2 joints move between the root link and 'lower'; allowed: 3 to 8."),
        (
            "max_speed_deg_s = [90, 180.0]",
            "",
            "arm.urdf: joint 'elbow': no velocity limit above 0. Write into .*: max_speed_deg_s = { elb",
        ),
        (
            "[90, 180.0]",
            "{ elbow = 90, wrist = 1 }",
            r"max_speed_deg_s names 'wrist'. The turning joints .* 'shoul",
        ),
        (
            "[90, 180.0]",
            "{ slide = 1 }",
            "max_speed_deg_s names 'slide'. The turning joints of the arm: 'shoul",
        ),
        ("[90, 180.0]", "{ elbow = '1' }", "robot.toml: max_speed_deg_s of 'elbow' is '1'. Give a finite number."),
        ("[90, 180.0]", "{ elbow = 0 }", "robot.toml: max_speed_deg_s of 'elbow' is 0. Give a positive value."),
        ("[90, 180.0]", "{ shoulder = 1 }", "joint 'elbow': no velocity limit above 0. Write into "),
        ("[0, 90]", "[0, 1" + "0" * 400 + "]", "Give a list of 2 finite numbers"),
        ("[0, 90]", "[0, 1e300]", "Give a list of 2 finite numbers"),
        ("[90, 180.0]", "[90, 1e308]", "Give a list of 2 finite numbers"),
        ('"arm.urdf"', '"a\\u0000b"', "is no readable robot: ValueError: .*embedded null"),
        ('"arm.urdf"', '"' + "x" * 5_000 + '"', "cannot be read"),
        ('"arm.urdf"', '"/dev/zero"', "it is no regular file"),
    ]:
        with subtests.test(old=old):
            tmp_path = tmp_path_factory.mktemp("case")
            toml = TOML.replace(old, new)
            assert toml != TOML
            with refused(message) as caught:
                read_robot(_write(tmp_path, toml=toml))
            assert any(file in str(caught.value) for file in (str(tmp_path), "/dev/zero"))


def test_numbers_may_stand_by_the_joints_names(robot, tmp_path):
    """In any order; what a table leaves out follows the rules."""
    by_name = TOML.replace("[90, 180.0]", "{ elbow = 180, shoulder = 90.0 }").replace("[0, 90]", "{ elbow = 90 }")
    named = read_robot(_write(tmp_path, toml=by_name))
    assert_array_equal(named.max_speed, robot.max_speed)
    assert (named.home[1], named.home[0]) == (robot.home[1], 0.5)  # the middle of the shoulder's range


def test_robot_toml_wins_over_a_placeholder(tmp_path_factory, subtests):
    """What is no speed limits none; without robot.toml the line to write is told, and it works."""
    for velocity in ["0", "0.0", "-1", "", "inf", "1.7976931348623157e+308", "x"]:
        with subtests.test(velocity=velocity):
            tmp_path = tmp_path_factory.mktemp("case")
            urdf = URDF.replace('velocity="1.5707963267948966"', f'velocity="{velocity}"')
            assert read_robot(_write(tmp_path, urdf=urdf)).max_speed[0] == np.pi / 2
            (tmp_path / "robot.toml").unlink()
            with refused("joint 'shoulder' and 1 more: no velocity limit above 0") as caught:
                read_robot(tmp_path / "arm.urdf")
            file, line = str(caught.value).rpartition("Write into ")[2].split(", with the arm's own numbers: ")
            Path(file).write_text(line)
            assert_allclose(read_robot(tmp_path / "arm.urdf").max_speed, [np.pi / 2, np.pi / 2, 0.15])


def test_robot_toml_wins_over_a_lower_speed_of_the_urdf(tmp_path):
    """A velocity there is often a placeholder; a line tells the joints that are allowed more, and no others."""
    (tmp_path / "plain").mkdir()
    assert read_robot(_write(tmp_path / "plain")).warnings == ()
    robot = read_robot(_write(tmp_path, toml=TOML.replace("[90, 180.0]", "[180, 180]").replace("[0.25]", "[0.75]")))
    assert_allclose(robot.max_speed, [np.pi, np.pi, 0.75])
    told = "robot.toml allows joint 'shoulder' 180 deg/s, the URDF 90; joint 'slide' 0.75 m/s, the URDF 0.5"
    assert robot.warnings == (told,)


def test_what_to_write_has_both_kinds_of_joints(tmp_path):
    """And names in quotes where TOML wants them."""
    urdf = URDF.replace(' velocity="0.5"', "").replace('"elbow"', '"the elbow"')
    with refused(r'max_speed_deg_s = { "the elbow" = 90 } and max_speed_m_s = \[0\.2\]$'):
        read_robot(_write(tmp_path, toml="", urdf=urdf) / "arm.urdf")


def test_fault_of_the_urdf_names_the_file(tmp_path):
    """What the URDF's reader refuses is passed on with the file in front."""
    with refused(r"arm\.urdf: Joint 'shoulder' has the limits 3 to 2\."):
        read_robot(_write(tmp_path, urdf=URDF.replace('lower="-1"', 'lower="3"')))


def test_more_joints_than_eight_are_refused(tmp_path):
    """A chain of nine is answered with the number."""
    joint = (
        '<link name="{0}"/><joint name="{0}" type="prismatic"><parent link="{1}"/><child link="{0}"/>'
        '<limit lower="0" upper="1" velocity="1" effort="1"/></joint>'
    )
    joints = "".join(joint.format(child, parent) for parent, child in pairwise(["base", *"abcdefghi"]))
    (tmp_path / "long.urdf").write_text(f'<robot name="long"><link name="base"/>{joints}</robot>')
    with refused(r"long\.urdf: 9 joints move between the root link and 'i'; allowed: 3 to 8\."):
        read_robot(tmp_path / "long.urdf")


def test_folder_without_robot_is_refused(tmp_path):
    """A folder that holds no robot.toml is no robot, nor is a URDF that is not there."""
    with refused(r": no robot\.toml in it\. Give the path of a URDF"):
        read_robot(tmp_path)
    with refused(r"leg\.urdf: cannot be read \(No such file or directory\)"):
        read_robot(tmp_path / "leg.urdf")


def test_file_in_another_encoding_is_refused(tmp_path):
    """Bytes that are no UTF-8 are answered with the file's name."""
    (_write(tmp_path) / "robot.toml").write_bytes(b'name = "\xff"')
    with refused(r"robot\.toml' cannot be read: 'utf-8' codec .* Give a TOML file in UTF-8"):
        read_robot(tmp_path)


def test_a_large_urdf_is_not_opened(tmp_path):
    """A sparse file of 10 GB is refused at once."""
    folder = _write(tmp_path)
    with (folder / "arm.urdf").open("wb") as file:
        file.truncate(10**10)
    with refused("it has 10,000,000,000 bytes, 4,194,304 are allowed"):
        read_robot(folder)


def test_too_many_shapes_are_refused(tmp_path):
    """Visible and colliding ones of all links together."""
    shapes = '<visual><geometry><sphere radius="1"/></geometry></visual>' * 1_001
    urdf = URDF.replace('<link name="tip"/>', f'<link name="tip">{shapes}</link>')
    with refused("The URDF has 1,001 shapes, 1,000 are allowed"):
        read_robot(_write(tmp_path, urdf=urdf))
