"""`harness parity`: what one types and sees."""

import subprocess
import sys

import pytest

FEW = ("--steps", 20, "--episodes", 2)
WRONG = """
import harness
from dataclasses import dataclass
from harness_plugins.kit import IdealSimulator
from harness.env.ideal import IdealSimulation

@harness.hookimpl
def register_simulators(register):
    register("exact", "wrong_arms:Exact", summary="moves exactly as told")
    register("high", "wrong_arms:High", summary="its tip is too high")
    register("shaky", "wrong_arms:Shaky", summary="falls apart")
    register("far", "wrong_arms:Far", summary="not here", requires=("no_such_engine",), extra="far")

@dataclass(frozen=True)
class Exact(IdealSimulator):
    pass

@dataclass(frozen=True)
class High:
    by: float = 0.001

    def open(self, robot, num_envs, control_period):
        simulation = IdealSimulation(robot, num_envs)
        state = simulation.state
        def higher():
            found = state()
            return found._replace(end_effector=found.end_effector + [0.0, 0.0, self.by])
        simulation.state = higher
        return simulation

@dataclass(frozen=True)
class Shaky:
    def open(self, robot, num_envs, control_period):
        raise RuntimeError("a screw is loose")
"""


@pytest.fixture(autouse=True)
def wrong_arms(tmp_path_factory, monkeypatch):
    """A plugin with one simulator that is right, and others that are not."""
    folder = tmp_path_factory.mktemp("site-packages")
    (folder / "wrong_arms.py").write_text(WRONG)
    metadata = folder / "wrong_arms-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: wrong-arms\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text("[harness]\nwrong = wrong_arms\n")
    monkeypatch.syspath_prepend(folder)


def test_the_table_is_relative_to_the_reference(harness):
    """The verdict, each other simulator against it, and every one's own errors and cost."""
    answer = harness("parity --sim exact,high", *FEW)
    assert (answer.status, answer.err) == (0, "")
    assert "Largest distance of the tip from exact's: 1 mm (high)" in answer.out
    for text in ("against exact", "placed tip", "seed 0", "dives to the ground"):
        assert text in answer.out


def test_json_is_one_object(harness):
    """Everything on standard output is the object."""
    data = harness("parity --sim exact,high,high:by=0.002 --json", *FEW).json
    assert (data["format"], data["reference"], data["robot"], data["steps"]) == (1, "exact", "fd100", 20)
    found = {(pair["a"], pair["b"]): pair["max_tip_error_m"] for pair in data["pairs"]}
    assert found == {
        ("exact", "high"): pytest.approx(0.001),
        ("exact", "high:by=0.002"): pytest.approx(0.002),
        ("high", "high:by=0.002"): pytest.approx(0.001),
    }
    for key in ("mean_tip_error_m", "max_joint_error_rad", "contact_disagreement"):
        assert isinstance(data["pairs"][0][key], float)
    assert data["simulators"][1]["placement_error_m"] == pytest.approx(0.001)
    assert data["simulators"][0]["seconds_per_step"] > 0.0


def test_the_reference_can_be_another(harness):
    """--reference comes first; it need not be named twice."""
    data = harness("parity --sim exact --reference high --json", *FEW).json
    assert data["reference"] == "high"
    assert [(pair["a"], pair["b"]) for pair in data["pairs"]] == [("high", "exact")]


def test_other_motions_can_be_asked_for(harness):
    """Robot, steps, episodes, seed and period are in the JSON as they were given."""
    flags = ("--robot", "unity-arm", "--steps", 7, "--episodes", 3, "--seed", 5, "--period", 0.05)
    data = harness("parity --sim exact,high --json", *flags).json
    keys = ("robot", "steps", "episodes", "seed", "control_period_s")
    assert [data[key] for key in keys] == ["unity-arm", 7, 3, 5, 0.05]
    assert len(data["pairs"][0]["curves"]["mean_tip_error_m"]) == 8


def test_one_that_fails_is_told_and_the_others_go_on(harness):
    """Status 1, the reason, and the comparison of the rest."""
    answer = harness("parity --sim exact,shaky,high", *FEW)
    assert answer.status == 1
    assert "failed: shaky: RuntimeError: a screw is loose" in answer.out
    assert "1 mm (high)" in answer.out
    failed = harness("parity --sim exact,shaky,high --json", *FEW)
    assert failed.status == 1
    assert failed.json["failed"] == [{"name": "shaky", "reason": "RuntimeError: a screw is loose"}]


def test_by_default_all_that_are_installed_are_compared(harness, monkeypatch):
    """Those that are not are listed with the extra that brings them; one that fails on the way is told."""
    monkeypatch.setenv("HARNESS_PLUGINS", "-simulators")  # no engine, which takes its time
    data = harness("parity --json", *FEW).json
    assert {simulator["name"] for simulator in data["simulators"]} == {"exact", "high"}
    assert {missing["name"]: missing["extra"] for missing in data["missing"]} == {"far": "far"}
    assert "shaky" in {failed["name"] for failed in data["failed"]}
    assert "not installed: far: pip install 'wrong-arms[far]'" in harness("parity", *FEW).out


def test_html_writes_a_page_beside_the_table(harness, tmp_path):
    """Told on standard error."""
    pytest.importorskip("jinja2")
    answer = harness("parity --sim exact,high --html p.html", *FEW)
    assert (answer.status, answer.err) == (0, "Page: p.html\n")
    assert "1 mm (high)" in answer.out
    assert "high against exact" in (tmp_path / "p.html").read_text()


def test_usage_errors_are_one_line(harness, tmp_path, subtests):
    """Status 2, one line that says what was given, nothing on standard output, nothing written."""
    for arguments, text in [
        (("--sim", "exct"), "Did you mean 'exact'?"),
        (("--sim", "exact,exact"), "--sim names 'exact' twice"),
        (("--sim", "high:by=much"), "by"),
        (("--sim", "exact", "--reference", "hi"), "No simulator 'hi'"),
        (("--sim", "far"), "needs no_such_engine: pip install 'wrong-arms[far]'"),
        (("--sim", "exact,high", "--robot", "fd10"), "Did you mean 'fd100'?"),
        (("--steps", "0"), "--steps 0: must be at least 1"),
        (("--episodes", "0"), "--episodes 0: must be at least 1"),
        (("--seed", "-1"), "--seed -1: must be at least 0"),
        (("--period", "0"), "--period 0: must be above 0"),
        (("--period", "nan"), "--period nan: must be above 0"),
        (("--sim", "exact,high", "--html", "no/p.html", *FEW), "'no/p.html' cannot be written"),
    ]:
        with subtests.test(arguments=arguments):
            answer = harness("parity", *arguments)
            assert (answer.status, answer.out, answer.err.count("\n")) == (2, "", 1)
            assert text in answer.err
            assert list(tmp_path.iterdir()) == []


def test_the_command_imports_what_it_compares_alone():
    """Neither torch nor an engine that was not named."""
    code = (
        "import sys; from harness.cli.app import _run;"
        "assert _run(['parity', '--sim', 'kinematic', '--steps', '3', '--episodes', '1']) == 0;"
        "assert not {'mujoco', 'pybullet', 'dm_control', 'torch', 'plotly'} & sys.modules.keys()"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)
