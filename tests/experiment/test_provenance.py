"""What decides a result beside its cell."""

import json
import re
import subprocess
import sys
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from platform import machine

import numpy as np
import pytest

from harness import load_registry
from harness.experiment.provenance import (
    blas_kernel,
    describe_environment,
    describe_machine,
    source_commit,
    versions_behind,
)
from harness.registry import Choice, Spec
from harness_plugins.rewards import arp
from tests.registered import FD100 as ROBOT


def test_environment_of_a_run(make_cell, toys, monkeypatch):
    """What decides a result beside the cell, as JSON: versions, machine, engine, commit, command, sources."""
    monkeypatch.setattr("sys.argv", ["/somewhere/bin/harness", "run", "--sim", "ideal"])
    described = describe_environment(make_cell(), ROBOT, toys)
    assert list(described) == ["versions", "machine", "engine", "commit", "command", "sources"]
    assert described["command"] == "harness run --sim ideal"
    assert json.loads(json.dumps(described)) == described


def test_the_recorded_command_can_be_pasted(make_cell, toys, monkeypatch):
    """A page shows it: a folder in it is quoted as it had to be typed."""
    monkeypatch.setattr("sys.argv", ["harness", "run", "--out", ";touch X; a b"])
    assert describe_environment(make_cell(), ROBOT, toys)["command"] == "harness run --out ';touch X; a b'"


def test_versions_are_those_that_run(toys):
    """The numpy of this process is the one that is recorded, whatever the plugins."""
    assert versions_behind([])["numpy"] == np.__version__


def test_versions_of_a_plugins_libraries_are_recorded(write_plugin):
    """What a third party requires is recorded like MuJoCo, by the name of its distribution, and its own version too."""
    source = """
import harness

@harness.hookimpl
def register_simulators(register):
    register("mine", "nowhere:Mine", summary="s", requires=["yaml_of_mine", "safetensors.numpy", "PIL"])
"""
    spec = load_registry([write_plugin(source, "mine")]).get("simulators", "mine")
    versions = versions_behind([spec])
    assert versions["safetensors"] == version("safetensors")
    assert versions["pillow"] == version("pillow")  # another name than the module's
    assert "yaml-of-mine" not in versions  # it is not installed


def test_a_library_that_is_not_installed_is_not_searched_for(monkeypatch):
    """All distributions are asked for who brings a module, which takes a fifth of a second, only where it is there."""
    asked = []
    monkeypatch.setattr("importlib.metadata.packages_distributions", lambda: asked.append("all") or {})
    versions_behind([Spec("simulators", "mine", "nowhere:Mine", "s", ("yaml_of_mine",), None, "mine", "mine")])
    assert asked == []


def test_versions_of_other_plugins_are_left_out(make_cell, toys):
    """A cell of the toy arm does not depend on MuJoCo, whatever is installed."""
    assert "mujoco" not in describe_environment(make_cell(), ROBOT, toys)["versions"]


def test_versions_of_an_engine_are_recorded(make_cell, toys):
    """Of every library that the built-in engine requires."""
    cell = make_cell(simulator=Choice("dm_control", (), "dm_control"))
    assert {"dm-control", "mujoco"} <= describe_environment(cell, ROBOT, toys, ["simulators"])["versions"].keys()


def test_the_engine_is_recorded(make_cell, toys):
    """By the name that simulators of one engine share; None where there is none."""
    engines = {
        name: describe_environment(make_cell(simulator=Choice(name, (), name)), ROBOT, toys)["engine"]
        for name in ("mujoco", "dm_control", "kinematic")
    }
    assert engines == {"mujoco": "MuJoCo", "dm_control": "MuJoCo", "kinematic": None}


def test_machine_names_its_cpu():
    """The CPU decides which floating-point kernels run."""
    machine = describe_machine()
    assert machine["cpu"]
    assert machine["cores"] >= 1


@pytest.mark.skipif(not blas_kernel() or machine() not in ("x86_64", "AMD64"), reason="numpy has no such kernels")
def test_kernel_is_the_one_that_computes(monkeypatch):
    """Not the one that the CPU would have got."""
    monkeypatch.setenv("OPENBLAS_CORETYPE", "Nehalem")
    code = "from harness.experiment.provenance import describe_machine; print(describe_machine()['kernel'])"
    assert subprocess.check_output([sys.executable, "-c", code], text=True) == "Nehalem\n"


def test_sources_are_hashes_of_the_files(make_cell, toys):
    """A result whose reward was changed since can be told by the hash of the reward's file."""
    hashes = describe_environment(make_cell(reward=Choice("arp", (), "arp")), ROBOT, toys)["sources"]
    assert set(hashes) == {"simulators", "tasks", "algorithms", "rewards", "robots"}
    assert hashes["rewards"] == sha256(Path(arp.__file__).read_bytes()).hexdigest()


def test_sources_are_those_of_the_kinds_that_made_the_result(make_cell, toys):
    """An evaluation does not depend on the library that trained the policy."""
    assert set(describe_environment(make_cell(), ROBOT, toys, ["simulators"])["sources"]) == {"simulators", "robots"}


def _repository(folder, name):
    """A repository with one commit, and with a project of that name in it."""
    folder.mkdir()
    if name is not None:
        (folder / "pyproject.toml").write_text(f'[project]\nname = "{name}"\n')
    (folder / "file").write_text("x")
    git = ["git", "-C", str(folder), "-c", "user.name=n", "-c", "user.email=e@x"]
    for arguments in (["init", "-q"], ["add", "-A"], ["commit", "-qm", "first"]):
        subprocess.run([*git, *arguments], check=True)
    return folder


def test_commit_is_that_of_the_projects_own_checkout(tmp_path):
    """40 digits, and a plus sign where files differ from it."""
    checkout = _repository(tmp_path / "mine", "fd100-harness")
    clean = source_commit(checkout)
    (checkout / "file").write_text("y")
    assert re.fullmatch("[0-9a-f]{40}", clean)
    assert source_commit(checkout) == clean  # what a process runs was loaded before
    source_commit.cache_clear()
    assert source_commit(checkout) == f"{clean}+"


@pytest.mark.parametrize("name", ["someones-project", None])
def test_repository_around_the_installation_does_not_count(tmp_path, name):
    """Neither one whose root the package lies in, nor one that only has the installation somewhere inside."""
    other = _repository(tmp_path / "theirs", name)
    (other / "site-packages").mkdir()
    for folder in (other, other / "site-packages"):
        assert source_commit(folder) == ""
