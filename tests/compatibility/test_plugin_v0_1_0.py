"""A package of plugins that was written for version 0.1.0 loads, trains and passes its own tests, unchanged.

``plugin_v0_1_0`` imports from where names stood then, and keeps to what the pages of that version said.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
PACKAGE = HERE / "plugin_v0_1_0"
KINDS = "simulator wary-sim algorithm wary-algo reward wary reward wary-half metric wary-way task wary-reach command"


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The environment of a process in which the package is installed."""
    folder = tmp_path_factory.mktemp("site-packages")
    (folder / "wary_arm").symlink_to(PACKAGE / "wary_arm")
    metadata = folder / "wary_arm-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: wary-arm\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text("[harness]\nwary = wary_arm.plugin\n")
    others = [path for path in [os.environ.get("PYTHONPATH", "")] if path]
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(folder), *others]), "OMP_NUM_THREADS": "1"}


def _python(environment: dict[str, str], *arguments: str) -> str:
    ended = subprocess.run(
        [sys.executable, *arguments], env=environment, capture_output=True, text=True, check=False, cwd="/"
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return ended.stdout


def test_all_its_plugins_load(installed: dict[str, str]):
    """Everything that it registers is imported and fits; a remark says of each old name where it stands now."""
    told = json.loads(_python(installed, "-m", "harness", "plugins", "--check", "--json"))["plugins"]
    (wary,) = [plugin for plugin in told if plugin["name"] == "wary"]
    assert (wary["status"], wary["reason"]) == ("ok", "")
    assert " ".join(wary["registered"]) == f"{KINDS} wary-reaches"
    assert wary["remarks"][0] == "written for harness_api 1, this is 2: docs/renamed.md says what changed"
    moved = "harness.trace.Trace moved: from harness.log import Log (the old name goes with 0.3.0)"
    assert f"{moved}, in wary_arm.metric" in wary["remarks"]


def test_it_trains(installed: dict[str, str], tmp_path: Path):
    """A comparison of its reward with its other one, by its algorithm, task and simulator, with its metric."""
    names = ["--sim", "wary-sim", "--algo", "wary-algo", "--task", "wary-reach"]
    rewards = ["--reward", "wary,wary-half", "--baseline", "wary", "--metric", "wary-way"]
    sizes = ["--seeds", "1", "--steps", "24", "--evaluation-episodes", "2"]
    said = _python(installed, "-m", "harness", "run", *names, *rewards, *sizes, "--json", "--out", str(tmp_path))
    told = json.loads(said)
    assert {cell["status"] for cell in told["cells"]} == {"done"}
    assert "wary-way" in [measure["name"] for measure in told["combinations"][0]["behaviour"]]


def test_its_command_runs(installed: dict[str, str]):
    """It loads a robot by the old name."""
    assert _python(installed, "-m", "harness", "wary-reaches") == "1.54 m\n"


@pytest.mark.slow
def test_its_tests_pass(installed: dict[str, str]):
    """With the old names of the contract kit, and names of checks by ``check.__name__``."""
    options = ["-q", "-p", "no:cacheprovider", "-c", os.devnull, "--rootdir", str(PACKAGE)]
    said = _python(installed, "-m", "pytest", str(PACKAGE / "wary_arm_tests.py"), *options)
    assert " passed" in said
    assert "harness.testing.samples.random_samples moved: from harness.testing.rewards.samples import" in said
