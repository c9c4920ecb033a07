"""What pytest offers where the harness is installed."""

import subprocess
import sys
import tomllib

import pytest

import harness
from harness_plugins.kit.opened import train_cell
from tests.project import ROOT, page_of

PLUGIN = "harness.pytest_plugin"
"""What people type after ``-p``; the module stands elsewhere."""
ONCE = {"sim": "kinematic", "algo": "random", "reward": "arp", "steps": 4, "evaluation_episodes": 1}


@pytest.fixture(scope="module", autouse=True)
def _everything_is_imported(tmp_path_factory):
    """A pytest within this process forgets what it was first to import, and others would import it twice."""
    train_cell(tmp_path_factory.mktemp("once") / "cell", **ONCE)
    harness.make_env("kinematic", reward="arp", robot="unity-arm").close()


@pytest.fixture
def pytester(pytester):
    """A pytest of its own, in this process, with strict markers."""
    pytester.plugins = [PLUGIN]
    pytester.makeini("[pytest]\naddopts = --strict-markers -p no:cacheprovider\n")
    return pytester


def _passes(pytester, source, *arguments, **outcomes):
    pytester.makepyfile(source)
    result = pytester.runpytest_inprocess("-p", PLUGIN, *arguments)
    result.assert_outcomes(**(outcomes or {"passed": 1}))
    return result


def test_a_step_is_timed_in_one_line(pytester):
    """With pytest-benchmark; here each call is made once."""
    source = "def test_step(benchmark, stepping):\n    benchmark(stepping('kinematic', 64))\n"
    _passes(pytester, source, "--benchmark-disable")


def test_stepping_drives_all_arms_for_a_period(pytester):
    """Where they are told to be; the simulator is closed when the test ends."""
    _passes(
        pytester,
        """
        import numpy as np
        import pytest
        from harness_plugins.simulators.kinematic import KinematicSimulation

        closed = []

        @pytest.fixture
        def watched(monkeypatch):
            monkeypatch.setattr(KinematicSimulation, "close", lambda self: closed.append(self))

        def test_moves(watched, stepping):
            step = stepping("kinematic", num_envs=3, period=0.5, robot="unity-arm")
            first = step()
            before = first.qpos.copy()
            again = step()
            assert before.shape == (3, 5)
            assert (again.qpos != before).any(axis=1).all()
            np.testing.assert_allclose(again.qvel, (again.qpos - before) / 0.5)
            assert not closed

        def test_is_closed():
            assert len(closed) == 1
        """,
        passed=2,
    )


def test_the_marker_says_what_fixtures_are_made_of(pytester):
    """What is nearest to the test wins; without one it is an arm without an engine."""
    _passes(
        pytester,
        """
        import pytest

        pytestmark = pytest.mark.harness(num_envs=2, task="fd100-reach:horizon=7")

        @pytest.mark.harness(num_envs=5, reward="arp:k2=2")
        def test_marked(reach_env, simulation):
            assert (reach_env.num_envs, reach_env.task.horizon, reach_env.reward.k2) == (5, 7, 2.0)
            assert simulation.read().qpos.shape == (5, 6)

        @pytest.mark.harness(robot="unity-arm")
        def test_robot(reach_env, simulation):
            assert simulation.read().qpos.shape == (2, reach_env.robot.dof) == (2, 5)
        """,
        passed=2,
    )


def test_a_cell_is_trained_and_evaluated(pytester):
    """In this process: its folder, and what its manifest says."""
    _passes(
        pytester,
        """
        import pytest

        @pytest.mark.harness(steps=10, reward="arp")
        def test_cell(cell):
            folder, manifest = cell
            assert manifest.status == "done", manifest.reason
            assert (manifest.cell.steps, manifest.cell.reward.name) == (10, "arp")
            assert (folder / "evaluation.parquet").exists()
        """,
    )


@pytest.mark.parametrize(
    ("marker", "told"),
    [
        ("simm='kinematic'", "does not take simm; by name: sim, task, reward"),
        ("'kinematic'", "does not take 'kinematic'; by name"),
        ("sim='kinematik'", "Did you mean 'kinematic'?"),
        ("num_envs=0", "num_envs=0: must be at least 1"),
    ],
)
def test_a_marker_that_nobody_understands_is_an_error(pytester, marker, told):
    """It says what was given and what there is."""
    source = f"import pytest\n@pytest.mark.harness({marker})\ndef test_it(simulation):\n    pass\n"
    _passes(pytester, source, errors=1).stdout.fnmatch_lines([f"*{told}*"])


def test_it_imports_nothing_before_a_test_asks():
    """Neither numpy nor the rest: everybody's pytest starts with it."""
    code = (
        "import sys, pytest, harness_plugins.kit.pytest_plugin; "
        "heavy = {'numpy', 'gymnasium', 'torch', 'pydantic', 'harness_plugins.kit.opened', 'harness.env'}; "
        "found = heavy & set(sys.modules); "
        "assert not found, found"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_pytest_finds_it_by_its_entry_point():
    """Under the name that people type: `-p harness.pytest_plugin` names the same plugin."""
    points = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"]["pytest11"]
    assert points == {PLUGIN: "harness_plugins.kit.pytest_plugin"}


def test_the_fixtures_are_those_of_the_page(pytester):
    """The last snippet of docs/authoring.md passes as it stands."""
    page = page_of("authoring")
    _passes(pytester, page.rsplit("```python\n", 1)[1].split("```")[0], "--benchmark-disable", passed=3)
