"""Arms of installed packages, which are not imported."""

import json
import sys
from pathlib import Path

import pytest

from harness import load_registry, load_robot
from harness.robot.packages import find_installed, is_installed, locate
from harness.robot.robot import read_robot
from tests.refusals import refused
from tests.robot.brought_arms import ARM, changed

URDF = "fake_arms:arms/one/one.urdf"


@pytest.fixture
def site(tmp_path, monkeypatch):
    """A folder that pip could have installed into: the package `fake_arms`, and `fake-data` with files alone."""
    folder = tmp_path / "site-packages"
    (folder / "fake_arms" / "arms" / "one").mkdir(parents=True)
    (folder / "fake_arms" / "__init__.py").write_text("raise RuntimeError('imported')\n")
    (folder / "fake_arms" / "arms" / "one" / "one.urdf").write_text(ARM)
    (folder / "prefix" / "share").mkdir(parents=True)
    (folder / "prefix" / "share" / "two.urdf").write_text(ARM)
    for name, file in (("fake-arms", "fake_arms/__init__.py"), ("fake-data", "prefix/share/two.urdf")):
        info = folder / f"{name.replace('-', '_')}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        (info / "RECORD").write_text(f"{file},,\n")
    monkeypatch.syspath_prepend(str(folder))
    return folder


def test_files_of_packages_are_found(site):
    """From the folder of what is imported on; else from where pip installs on."""
    assert find_installed(URDF) == site / "fake_arms" / "arms" / "one" / "one.urdf"
    assert find_installed("fake-data:prefix/share/two.urdf") == site / "prefix" / "share" / "two.urdf"
    assert "fake_arms" not in sys.modules


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("fake_arms:arms/one/on.urdf", r"has no 'arms/one/on.urdf'. Of .urdf there is: arms/one/one.urdf. Correct the"),
        ("fake-data:prefix/share/tow.urdf", r"has no .*. Of .urdf there is: prefix/share/two.urdf. Correct the path"),
        ("fake_arms:arms/a.xml", r"has no 'arms/a.xml'. No .xml file lies there. Correct the path"),
        ("fake_arm:arms/one/one.urdf", r"No package 'fake_arm' is installed. Did you mean 'fake_arms'\? Correct the"),
        ("no.such:one.urdf", r"No package 'no.such' is installed\. .*install it, or give the path"),
    ],
)
def test_what_is_not_there_is_told_with_what_is(site, name, message):
    """A near miss of the package, or of its files."""
    with refused(message):
        load_robot(name)


def test_names_of_other_things_are_no_packages():
    """Drives, addresses, paths and specs of plugins."""
    assert [is_installed(name) for name in ("C:/a.urdf", "file://a", "a/b:c", "fd100", "a:/b", "/a:b")] == [False] * 6
    assert is_installed("example-robot-data:cmeel.prefix/share/a.urdf")


def test_a_path_that_exists_is_that(tmp_path, monkeypatch):
    """Whatever it is called."""
    (tmp_path / "fake_arms:a").mkdir()
    (tmp_path / "fake_arms:a" / "b.urdf").write_text(ARM)
    monkeypatch.chdir(tmp_path)
    assert load_robot("fake_arms:a/b.urdf").name == "b"
    assert locate("fake_arms:a", tmp_path, "") == tmp_path / "fake_arms:a"
    assert locate("~/a", tmp_path, "") == Path.home() / "a"


def test_arm_is_the_same_however_it_is_given(site, tmp_path):
    """As a package's file, by its path, by a robot.toml that names either, and that by its folder or itself."""
    path = site / "fake_arms" / "arms" / "one" / "one.urdf"
    robots = [load_robot(URDF), load_robot(path)]
    for number, urdf in enumerate((URDF, str(path), "../site-packages/fake_arms/arms/one/one.urdf")):
        folder = tmp_path / str(number)
        folder.mkdir()
        (folder / "robot.toml").write_text(f"urdf = {json.dumps(urdf)}\n")
        robots += [load_robot(folder), load_robot(str(folder / "robot.toml"))]
    assert len({robot.digest for robot in robots}) == 1
    assert {robot.name for robot in robots} == {"one"}


def test_robot_toml_beside_is_read_where_it_names_the_file_in_full(tmp_path):
    """As where it names it by its name; of one that names another file nothing is taken."""
    (tmp_path / "arm.urdf").write_text(ARM)
    (tmp_path / "other.urdf").write_text(ARM)
    (tmp_path / "robot.toml").write_text(f'name = "mine"\nurdf = {json.dumps(str(tmp_path / "arm.urdf"))}\n')
    assert [read_robot(tmp_path / file).name for file in ("arm.urdf", "other.urdf")] == ["mine", "other"]


def test_nobody_is_sent_to_where_packages_lie(site):
    """What has to be written goes into a robot.toml of one's own, which works."""
    path = site / "fake_arms" / "arms" / "one" / "one.urdf"
    path.write_text(changed(('velocity="2"', 'velocity="0"')))
    for given in (URDF, str(path)):
        with refused(r"Write into a robot\.toml of your own with urdf = ") as caught:
            load_robot(given)
        before, _, line = str(caught.value).partition("Write into a robot.toml of your own with ")
        urdf, _, speeds = line.partition(", with the arm's own numbers: ")
        own = site.parent / "own"
        own.mkdir(exist_ok=True)
        (own / "robot.toml").write_text(f"{urdf}\n{speeds}\n")
        assert load_robot(own).max_speed.round(3).tolist() == [1.571] * 4
        assert before == f"{given}: joint 'j1' and 3 more: no velocity limit above 0. "


def test_missing_package_of_a_robot_toml_names_the_file(site, tmp_path):
    """And so does a folder of meshes in one."""
    (tmp_path / "robot.toml").write_text('urdf = "fake_arm:one.urdf"\n')
    with refused(r"^.*/robot\.toml: No package 'fake_arm' is installed"):
        read_robot(tmp_path)
    (tmp_path / "robot.toml").write_text(f'urdf = "{URDF}"\nmeshes = {{ a = "fake_arm:one" }}\n')
    with refused(r"^.*/robot\.toml: No package 'fake_arm' is installed"):
        read_robot(tmp_path)


def test_registered_names_stay_what_they_are(site):
    """Qualified ones look like paths, and are none."""
    registry = load_registry()
    assert load_robot("fd100", registry).name == "fd100"
    distribution = registry.get("robots", "fd100").distribution
    assert load_robot(f"{distribution}/fd100", registry).name == "fd100"
