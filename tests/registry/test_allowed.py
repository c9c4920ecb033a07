"""Modules that an environment's id may import."""

import os
import subprocess
import sys

import pytest

from harness.errors import UsageError
from harness.files import require_allowed
from harness.registry.allowed import VARIABLE, allow_imports, allow_typed, allowed_imports

ID = "evil:X-v0"
EVIL = """
import pathlib
pathlib.Path("ran").touch()
import gymnasium
gymnasium.register("X-v0", entry_point="gymnasium.envs.classic_control:PendulumEnv", max_episode_steps=5)
"""
EXPERIMENT = """
task = { name = "gymnasium", id = "evil:X-v0" }
algo = "random"
reward = ["own", "own"]
seeds = 1
steps = 5
evaluation_episodes = 1
"""


@pytest.fixture(autouse=True)
def nothing_allowed(monkeypatch):
    """As where nobody said anything."""
    monkeypatch.setenv(VARIABLE, "")


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with a module that leaves a trace when it is imported, and an experiment that names it."""
    folder = tmp_path_factory.mktemp("place")
    (folder / "evil.py").write_text(EVIL)
    (folder / "experiment.toml").write_text(EXPERIMENT)
    return folder


def harness(place, *words):
    """A command in that folder, whose modules Python finds."""
    environment = {**os.environ, "PYTHONPATH": str(place)}
    command = [sys.executable, "-m", "harness", *words]
    return subprocess.run(command, cwd=place, env=environment, capture_output=True, text=True, check=False)


def test_an_id_without_a_module_is_allowed():
    """Gymnasium knows it, or does not."""
    require_allowed("Pendulum-v1")


def test_an_id_with_a_module_is_refused():
    """The message names both, and what to do."""
    with pytest.raises(UsageError, match=r"'evil:X-v0' imports the module 'evil'.*--allow-import evil"):
        require_allowed(ID)


@pytest.mark.parametrize(
    "typed", ["gymnasium:id=evil:X-v0", "gymnasium:id=(evil:X-v0)", "gymnasium:lower=,id=(evil:X)"]
)
def test_what_the_user_typed_is_allowed(typed):
    """On the command line, or in a program."""
    allow_typed(["run", typed])
    require_allowed(ID)


def test_no_other_module_is_allowed_with_it():
    """Nor one inside it or around it."""
    allow_imports(["evil.inner"])
    assert allowed_imports() == {"evil.inner"}
    with pytest.raises(UsageError):
        require_allowed(ID)


@pytest.mark.parametrize("name", ["", "evil,other", "../evil", "a b"])
def test_what_is_no_name_of_a_module_is_refused(name):
    """In one line."""
    with pytest.raises(UsageError, match="give the name of a module"):
        allow_imports([name])


def test_an_experiment_file_imports_nothing(place):
    """One line, status 2, and nothing was run."""
    ended = harness(place, "run", "experiment.toml", "--dry-run")
    assert ended.returncode == 2
    assert "--allow-import evil" in ended.stderr
    assert len(ended.stderr.splitlines()) == 1
    assert not (place / "ran").exists()


@pytest.fixture(scope="module")
def trained(place):
    """The same folder with results, as the user's word lets the module be imported, in worker processes too."""
    ended = harness(place, "run", "experiment.toml", "--allow-import", "evil", "--out", "mine")
    assert ended.returncode == 0, ended.stderr
    (place / "ran").unlink()
    return place


@pytest.mark.parametrize("words", [("video", "mine"), ("report", "mine"), ("score", "mine", "--reward", "own")])
def test_a_results_folder_imports_nothing(trained, words):
    """Whoever made it chose the id."""
    harness(trained, *words)
    assert not (trained / "ran").exists()
