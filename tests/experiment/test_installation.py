"""What a machine has installed, told and compared."""

import platform
import shutil

import pytest

from harness import load_registry
from harness.experiment.installation import describe_installation, describe_workers, differences
from harness.registry import Choice, read_given
from tests.refusals import refused
from tests.registered import FD100
from tests.registry.test_given import REWARD


def test_versions_sources_and_robots_are_told(toys, make_cell):
    """Those of the plugins that the cells use, and of no others."""
    told = describe_installation([make_cell(), make_cell(seed=1)], toys)
    assert told["python"] == platform.python_version()
    assert told["toy-arm"] == "1.0"
    assert {"numpy", "kernel of OpenBLAS", "source of harness", "source of algorithm 'wander'", "robot 'fd100'"} <= set(
        told
    )
    assert "source of algorithm 'sweep'" not in told


def test_a_worker_tells_what_this_process_tells(toys, make_cell):
    """Where both find the same modules."""
    assert describe_workers([make_cell()]) == describe_installation([make_cell()], toys)


def test_a_worker_that_finds_other_sources_tells_them(toys, make_cell, toy_folder, tmp_path, monkeypatch):
    """What counts is what a cell would run on."""
    (tmp_path / "toy_arm.py").write_text((toy_folder / "toy_arm.py").read_text() + "# changed\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=":")
    (difference, *_) = differences(describe_installation([make_cell()], toys), describe_workers([make_cell()]))
    assert difference.startswith("source of simulator 'ideal' ")


def test_a_worker_has_a_file_that_is_not_there(toys, make_cell, tmp_path):
    """Its text goes with the question: the source has the same digest."""
    path = tmp_path / "my_reward.py"
    path.write_text(REWARD)
    given = read_given([path])
    cell = make_cell(reward=Choice("my_reward", (("scale", 1.0),), "my_reward"))
    here = describe_installation([cell], load_registry(given=given))
    path.unlink()
    assert describe_workers([cell], given) == here
    assert "source of reward 'my_reward'" in here
    with refused("No reward 'my_reward'"):
        describe_workers([cell])


def test_what_a_worker_lacks_is_told(toys, make_cell):
    """As it would be here."""
    with refused("No algorithm 'wonder'"):
        describe_workers([make_cell(algorithm=Choice("wonder"))])


def test_differences_name_both_sides():
    """What is the same is not named."""
    here, there = {"python": "3.11.7", "numpy": "2.4.6", "mujoco": "3.17.0"}, {"python": "3.11.7", "numpy": "2.3.0"}
    assert differences(here, there) == ["numpy 2.4.6 here, 2.3.0 there", "mujoco 3.17.0 here, none there"]
    assert differences(there, {**there, "jax": "0.10"}) == ["jax none here, 0.10 there"]


@pytest.mark.parametrize(("drive", "same"), [("ideal", True), ("servo", False)])
def test_drives_are_told_where_they_move_the_arm(toys, make_cell, tmp_path, drive, same):
    """A machine whose robot.toml has other drives tells another robot, where these decide a result."""
    told = []
    folder = shutil.copytree(FD100.folder, tmp_path / "arm")
    cell = make_cell(simulator=Choice("ideal", (("drive", drive),)), robot=str(folder))
    for latency in ("0.01", "0.02"):
        text = (folder / "robot.toml").read_text()
        (folder / "robot.toml").write_text(text.replace("latency_s = 0.01", f"latency_s = {latency}"))
        told.append(describe_installation([cell], toys))
    assert (told[0] == told[1]) is same
