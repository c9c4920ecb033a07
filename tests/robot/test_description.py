"""Robots in files that are no URDF: which reader is asked, and what is said where there is none."""

import zipfile
from dataclasses import dataclass

import pytest

from harness import load_robot
from harness.errors import PluginError, UsageError
from harness.registry import Registry, Spec
from harness.robot import Description
from harness.robot.robot import is_path, read_robot
from tests.refusals import refused
from tests.robot.brought_arms import ARM, read_arm

NOTHING = Registry()


@dataclass(frozen=True)
class Sound:
    """Its files say no more than that they are of a chain."""

    def recognises(self, path, head):
        return head == b"chain"

    def read(self, path, arguments, packages):
        return Description(ARM, tip="l4", home={"j1": 0.5}, home_origin="the chain's own")

    def write_example(self, folder):
        (folder / "arm.chain").write_text("chain")
        return folder / "arm.chain"


class Failing(Sound):
    """Raises what is no error of ours."""

    def read(self, path, arguments, packages):
        raise KeyError("a mistake of the reader")


def registry_of(name, requires=()):
    """One format, of a class here."""
    registry = Registry()
    target = f"{__name__}:{name}"
    registry.specs["descriptions", "chain"] = [
        Spec("descriptions", "chain", target, "", requires, None, "mine", "chains", "0.1")
    ]
    return registry


@pytest.fixture(autouse=True)
def importable(monkeypatch):
    """This module, by its name, wherever pytest has it."""
    monkeypatch.setitem(__import__("sys").modules, __name__, __import__("sys").modules[__name__])


@pytest.fixture
def chain(tmp_path):
    """A file of that format."""
    return Sound().write_example(tmp_path)


def said_of(path, registry=NOTHING):
    """The error about a file, without its path."""
    with pytest.raises(UsageError) as error:
        read_robot(path, registry)
    return str(error.value).removeprefix(f"{path}: ")


def test_the_reader_that_recognises_a_file_reads_it(chain):
    """Its tip and its resting pose are taken, by `load_robot` too."""
    for read in (read_robot, load_robot):
        robot = read(chain, registry_of("Sound"))
        assert robot.joint_names == ("j1", "j2", "j3", "j4")
        assert robot.end_effector_link == "l4"
        assert robot.home[0] == 0.5
        assert robot.origins["end_effector"] == "the frame of its tool"


def test_a_urdf_asks_no_reader(tmp_path):
    """Whatever is registered."""
    (tmp_path / "arm.urdf").write_text(ARM)
    assert read_robot(tmp_path / "arm.urdf", registry_of("Failing")).dof == 4


def test_a_reader_that_fails_is_blamed(chain):
    """By its name and package."""
    with pytest.raises(PluginError, match=r"Description format 'chain' of package chains 0\.1 raised KeyError"):
        read_robot(chain, registry_of("Failing"))


def test_a_reader_without_its_library_is_not_asked(chain):
    """What is said then is what is said of the file."""
    assert "not well-formed XML" in said_of(chain, registry_of("Sound", ("no_such_module",)))


FOREIGN = {
    "arm.urdf.xacro": ('<robot name="a"/>', "xacro has to be expanded: pip install 'fd100-harness[xacro]'"),
    "arm.urdf": ('<robot><xacro:arm name="a"/></robot>', "or xacro arm.urdf.xacro > arm.urdf, and give that"),
    "arm.xml": ("<!-- a --><mujoco/>", "an MJCF is read by MuJoCo: pip install 'fd100-harness[mujoco]'"),
    "part.xml": ("<mujocoinclude/>", "it is a part of an MJCF. Give the file that includes it"),
    "arm.sdf": ("<sdf/>", "an SDF is not read. Give the URDF or the xacro file"),
    "model.xml": ("<sdf version='1.6'/>", "ROS's sdformat_urdf makes one"),
    "arm.usda": ("#usda 1.0", "a USD is not read. Give the URDF that it was made of"),
    "arm.usd": ("PXR-USDC", "the URDF exporter of Isaac Sim"),
}


@pytest.mark.parametrize("name", FOREIGN)
def test_other_files_say_how_to_come_to_a_urdf(tmp_path, name):
    """One sentence, that begins with the file."""
    text, told = FOREIGN[name]
    (tmp_path / name).write_text(text)
    assert told in said_of(tmp_path / name)


def test_an_archive_is_to_be_unpacked(tmp_path):
    """Whatever its name."""
    with zipfile.ZipFile(tmp_path / "arm.zip", "w") as archive:
        archive.writestr("arm.urdf", ARM)
    assert said_of(tmp_path / "arm.zip") == "it is an archive. Unpack it, and give the URDF in it."


def test_a_damaged_urdf_is_said_to_be_one(tmp_path):
    """As before there were other formats."""
    (tmp_path / "arm.urdf").write_text("<robt/>")
    assert said_of(tmp_path / "arm.urdf") == "The outermost element is <robt>, a URDF's is <robot>. Give a URDF."


def test_a_urdf_takes_no_arguments(tmp_path):
    """They would change nothing, and silently."""
    with refused(r"arguments are given, and arm\.urdf is a URDF, which takes none"):
        read_arm(tmp_path, ARM, 'arguments = { a = "1" }\n')


def test_a_path_is_known_by_its_ending():
    """Without a slash too: no plugin is called so."""
    assert [is_path(name) for name in ("arm.xml", "arm.urdf.xacro", "arm.urdf", "fd100")] == [True, True, True, False]
