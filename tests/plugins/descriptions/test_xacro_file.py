"""xacro files: what they expand to, where packages are found, and that nobody else's choice expands one."""

import pytest

from harness.errors import UsageError
from harness.registry.allowed import PROGRAMS, allow_programs, allow_typed
from harness.robot.robot import read_robot
from harness_plugins.descriptions.xacro_file import EXAMPLE

pytest.importorskip("xacro")
INCLUDED = EXAMPLE.replace('"0.3"/>', '"0.3"/>\n  <xacro:include filename="$(find parts)/more.xacro"/>')


@pytest.fixture(autouse=True)
def nothing_allowed(monkeypatch):
    """No program is, and ROS is not there."""
    monkeypatch.setenv(PROGRAMS, "")
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)


def expand(folder, text=EXAMPLE, toml="", name="arm.urdf.xacro"):
    """The robot of a file that the user named, and of a robot.toml where one is given."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_text(text)
    if toml:
        (folder / "robot.toml").write_text(toml)
    allow_programs([str(folder / name)])
    return read_robot(folder / name)


def refused(folder, text=EXAMPLE, toml=""):
    """What is said of a file."""
    with pytest.raises(UsageError) as error:
        expand(folder, text, toml)
    return str(error.value).removeprefix(str(folder / "arm.urdf.xacro"))


def test_macros_are_expanded(tmp_path):
    """With the defaults of the arguments."""
    robot = expand(tmp_path)
    assert robot.joint_names == ("turret_joint", "upper_joint", "fore_joint")
    assert robot.chain.T_previous_joint[1, 2, 3] == 0.3


def test_arguments_come_from_robot_toml(tmp_path, subtests):
    """By name; one that the file does not have is refused, and one that it needs is asked for."""
    assert expand(tmp_path, toml='arguments = { length = "0.5" }').chain.T_previous_joint[1, 2, 3] == 0.5
    cases = {
        'arguments = { lenght = "0.5" }': ": it has no argument 'lenght'. Its arguments: length.",
        "arguments = { length = 0.5 }": "Give a table of texts",
    }
    for number, (toml, told) in enumerate(cases.items()):
        with subtests.test(toml):
            assert told in refused(tmp_path / str(number), toml=toml)
    text = EXAMPLE.replace('<xacro:arg name="length" default="0.3"/>', "")
    assert 'Give it in a robot.toml beside the file: arguments = { name = "value" }' in refused(tmp_path / "n", text)


def test_a_urdf_with_macros_is_one_too(tmp_path):
    """Whatever its name ends with; one that only declares the prefix, or has macros in a comment, is a URDF."""
    assert expand(tmp_path, name="arm.urdf").dof == 3
    expanded = expand(tmp_path).urdf.replace("<robot", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"', 1)
    (tmp_path / "plain").mkdir()
    (tmp_path / "plain" / "arm.urdf").write_text(expanded.replace("<link", "<!-- <xacro:old/> --><link", 1))
    assert read_robot(tmp_path / "plain" / "arm.urdf").dof == 3


PLACES = {
    "around": ("parts/urdf", "parts", ""),
    "beside": ("ws/arm/urdf", "ws/parts", ""),
    "by its package.xml": ("checkout/urdf", "checkout", ""),
    "ROS_PACKAGE_PATH": ("arm", "else/parts", "ROS_PACKAGE_PATH=else"),
    "the package itself": ("arm", "else/parts", "ROS_PACKAGE_PATH=else/parts"),
    "AMENT_PREFIX_PATH": ("arm", "ros/share/parts", "AMENT_PREFIX_PATH=ros"),
}


def test_packages_are_found(tmp_path, subtests, monkeypatch):
    """Where meshes of packages are."""
    for number, (place, (own, package, variable)) in enumerate(PLACES.items()):
        root = tmp_path / str(number)
        with subtests.test(place), monkeypatch.context() as environment:
            (root / package).mkdir(parents=True)
            (root / package / "more.xacro").write_text(EXAMPLE.replace("xacro:segment", "xacro:unused"))
            (root / package / "more.xacro").write_text("<robot xmlns:xacro='http://www.ros.org/wiki/xacro'/>")
            (root / package / "package.xml").write_text("<package><name>parts</name></package>")
            if variable:
                name, _, value = variable.partition("=")
                environment.setenv(name, str(root / value))
            assert expand(root / own, INCLUDED).dof == 3
    (tmp_path / "last").mkdir()
    toml = f'meshes = {{ parts = "{tmp_path / "0" / "parts"}" }}'
    assert expand(tmp_path / "last", INCLUDED, toml).dof == 3


def test_a_package_that_is_not_there_is_asked_for(tmp_path):
    """With the key to write."""
    said = refused(tmp_path / "arm", INCLUDED)
    assert ': $(find parts) leads nowhere. Say in a robot.toml beside it: meshes = { parts = "FOLDER" }' in said


def test_mistakes_are_told(tmp_path, subtests):
    """In a sentence; nothing is printed."""
    cases = {
        "an expression": (EXAMPLE.replace("-pi / 2", "-py / 2"), "name 'py' is not defined"),
        "only macros": (EXAMPLE[: EXAMPLE.index('  <link name="base"/>')] + "</robot>", "a file of macros, it seems"),
        "no XML": (EXAMPLE[:-20], "xacro cannot expand it"),
        "a device": (INCLUDED.replace("$(find parts)/more.xacro", "/dev/zero"), "it is no regular file"),
        "too long": (EXAMPLE.replace('"base"/>', "\"${'x' * 10**7}\"/>"), "bytes of URDF, 4,194,304 are allowed"),
        "too large": (EXAMPLE.replace('"base"/>', '"${[0 for it in range(10**11)]}"/>'), "xacro cannot expand it"),
    }
    for number, (case, (text, told)) in enumerate(cases.items()):
        with subtests.test(case):
            assert told in refused(tmp_path / str(number), text)


def test_nothing_is_printed(tmp_path, capfd):
    """Even what xacro says on standard error."""
    refused(tmp_path, EXAMPLE.replace("-pi / 2", "-py / 2"))
    assert capfd.readouterr() == ("", "")


def test_a_file_that_nobody_named_is_not_expanded(tmp_path):
    """It is a program: its expressions reach all of Python. Here one would write a file."""
    path = tmp_path / "arm.urdf.xacro"
    path.write_text(EXAMPLE.replace("-pi / 2", "[open('ran', 'w')]"))
    (tmp_path / "robot.toml").write_text('urdf = "arm.urdf.xacro"\n')
    for given in (path, tmp_path):
        with pytest.raises(UsageError, match=r"a xacro file is a program, .* add --allow-program"):
            read_robot(given)
    assert not (tmp_path / "ran").exists()


def test_what_is_typed_is_named(tmp_path):
    """As an argument of a command, or behind a flag and ``=``."""
    path = tmp_path / "arm.urdf.xacro"
    path.write_text(EXAMPLE)
    for typed in (str(path), f"--robot={path}"):
        with pytest.MonkeyPatch.context() as environment:
            environment.setenv(PROGRAMS, "")
            allow_typed(["describe", typed])
            assert read_robot(path).dof == 3
