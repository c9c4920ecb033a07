"""`--plugin FILE`: a reward in fifteen lines, from its first run to its report elsewhere."""

import json
import os
import shutil

import pytest

from tests.registry.test_given import REWARD


@pytest.fixture
def file(tmp_path):
    """A file with one reward."""
    (tmp_path / "my_reward.py").write_text(REWARD)
    return "my_reward.py"


LINE = "run --plugin my_reward.py --reward my_reward:scale=2 --seeds 1 --out mine"


@pytest.fixture
def ran(trained, quick, file):
    """An experiment that it taught."""
    assert trained(LINE, *quick).status == 0
    return "mine"


def _manifests(folder):
    return [json.loads(path.read_text()) for path in folder.glob("cells/*/manifest.json")]


def test_reward_of_a_file_teaches_and_is_recorded(harness, ran, tmp_path, file):
    """Its SHA-256 stands in the manifest and in experiment.toml."""
    from hashlib import sha256

    digest = sha256((tmp_path / file).read_bytes()).hexdigest()
    (taught,) = [it for it in _manifests(tmp_path / "mine") if it["cell"]["reward"]["label"] == "my_reward:scale=2"]
    assert taught["environment"]["sources"]["rewards"] == digest
    assert f'sha256 = "{digest}"' in (tmp_path / "mine" / "experiment.toml").read_text()


def test_the_experiment_elsewhere_says_what_is_missing(harness, ran, file):
    """And does nothing again where it is given."""
    again = ("run", f"{ran}/experiment.toml", "--executor", "here", "--out", ran)
    missing = harness(*again)
    assert missing.status == 2
    assert "The experiment needs the plugin my_reward.py (SHA-256 " in missing.err
    assert "give --plugin" in missing.err
    assert harness(*again, "--plugin", file).status == 0


def test_edited_file_is_another_plugin(harness, ran, file, tmp_path):
    """Its done cells are not mixed with new ones in silence."""
    (tmp_path / file).write_text(REWARD.replace("self.scale *", "2 * self.scale *"))
    answer = harness("run mine/experiment.toml --executor here --out mine --plugin my_reward.py")
    assert answer.status == 2
    assert "made by another my_reward" in answer.err


def test_report_stands_without_the_file(harness, ran, file):
    """As with any plugin that is not installed; with it, everything is split again."""
    assert "No reward 'my_reward'" in json.dumps(harness("report mine --json").json["combinations"][0])
    assert "No reward" not in json.dumps(harness("report mine --json --plugin my_reward.py").json["combinations"][0])


def test_commands_that_a_report_suggests_give_the_file(harness, quick, file, tmp_path):
    """The command that shows all numbers runs as it is printed."""
    harness(LINE, *quick)
    told = harness("report mine --plugin my_reward.py").out.split()
    assert told[-3:] == ["--details", "--plugin", str(tmp_path / file)]


def test_other_commands_take_the_file_too(harness, ran, file, transferred_here):
    """List, describe, score, audit, transfer."""
    assert "my_reward         Pays the way" in harness("describe rewards --plugin my_reward.py").out
    assert "of my_reward.py" in harness("describe my_reward --plugin my_reward.py").out
    assert harness("score mine --reward my_reward --plugin my_reward.py").status == 0
    assert harness("audit --reward my_reward --plugin my_reward.py --episodes 2 --budget 0").status == 0
    assert harness("transfer mine --to stuck --plugin my_reward.py").status == 0


def test_qualified_names_are_names(harness, tmp_path):
    """A third party's is recorded as it was typed; a built-in one's is its plain one."""
    names = ("--sim", "toy-arm/ideal", "--algo", "Toy_Arm/wander", "--reward", "fd100-harness/arp", "--seeds", "1")
    small = ("--steps", "12", "--evaluation-episodes", "2", "--executor", "here", "--out", "mine")
    assert harness("run", *names, *small).status == 0
    cells = [it["cell"] for it in _manifests(tmp_path / "mine")]
    assert {cell["algorithm"]["name"] for cell in cells} == {"toy-arm/wander"}
    assert {cell["reward"]["name"] for cell in cells} == {"baseline", "arp"}
    assert harness("report mine").status == 0


SIMULATOR = """
from dataclasses import dataclass
from harness_plugins.simulators.kinematic import Kinematic

@dataclass(frozen=True)
class MySim:
    def open(self, robot, num_envs, control_period):
        return Kinematic().open(robot, num_envs, control_period)
"""


def test_parity_takes_the_file(harness, tmp_path):
    """A simulator of a file differs from the one that it is made of in nothing."""
    (tmp_path / "my_sim.py").write_text(SIMULATOR)
    few = ("--steps", 3, "--episodes", 1, "--json")
    answer = harness("parity --plugin my_sim.py --sim my_sim --reference kinematic", *few)
    assert answer.status == 0
    assert "my_sim" in answer.out
    assert "No simulator 'my_sim'" in harness("parity --sim my_sim --reference kinematic", *few).err


def test_eta_takes_the_file(harness, ran, file, tmp_path):
    """What paid the runs is found among its rewards, and an eta is split by it."""
    for label in ("baseline", "my_reward:scale=2"):
        (trained,) = [
            path.parent
            for path in (tmp_path / "mine").glob("cells/*/manifest.json")
            if json.loads(path.read_text())["cell"]["reward"]["label"] == label
        ]
        shutil.copytree(trained, tmp_path / label.partition(":")[0])
    groups = ("--baseline", "baseline/trace.parquet", "--proposed", "my_reward/trace.parquet", "--json")
    named = ("--proposed-reward", "my_reward:scale=2")
    assert "No reward 'my_reward'" in harness("eta", *groups, *named).err
    assert harness("eta", *groups, *named, "--plugin", file).json["rewards"]["proposed"] == "my_reward:scale=2"


AWAY = "__import__('os').chdir('elsewhere')"
METRIC = f"""
from dataclasses import dataclass
from typing import ClassVar

@dataclass(frozen=True)
class Mine:
    \"\"\"Counts rows.\"\"\"

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"

    def __call__(self, trace):
        {AWAY}
        return float(len(trace))
"""
ENVIRONMENT = f"""
import gymnasium
from dataclasses import dataclass

@dataclass(frozen=True)
class MyEnvironment:
    baseline = "own"
    lower_is_better = frozenset(["speed"])

    def make(self):
        {AWAY}
        return gymnasium.make("Pendulum-v1")

    def rewards(self, env):
        return {{"own": "own"}}

    def behaviour(self, env):
        return {{"speed": lambda observation, action, after, info: float(after[2])}}
"""
ARM = "--algo random --steps 20 --jobs 2 --sim"
MOVING = {
    "file": (f"{AWAY}\n{REWARD}", f"{ARM} kinematic --reward mine"),
    "reward": (REWARD.replace("return ()", f"return {AWAY} or ()"), f"{ARM} kinematic --reward mine"),
    "metric": (METRIC, f"{ARM} kinematic --reward arp"),
    "simulator": (SIMULATOR.replace("return ", f"return {AWAY} or "), f"{ARM} mine --reward arp"),
    "environment": (ENVIRONMENT, "--algo random --steps 20 --jobs 2 --task mine --reward own"),
}
"""By what changes the folder: a file, and what is trained with it."""


@pytest.mark.slow
@pytest.mark.parametrize("kind", MOVING)
def test_a_plugin_that_changes_the_folder_moves_no_path(harness, tmp_path, kind):
    """What is written lies where it was typed, and is named so, whichever process writes it."""
    source, flags = MOVING[kind]
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "mine.py").write_text(source.replace("'elsewhere'", repr(str(tmp_path / "elsewhere"))))
    answer = harness(f"run --plugin mine.py {flags} --baseline none --seeds 2 --evaluation-episodes 2 --out mine")
    assert (answer.status, os.getcwd()) == (0, str(tmp_path)), answer.err
    assert "Results: mine\n" in answer.out
    assert len([*(tmp_path / "mine" / "cells").iterdir()]) == 2
    assert not [*(tmp_path / "elsewhere").iterdir()]
