"""`harness check`: a verdict and a sentence for every check, whatever the plugin does."""

import contextlib
import textwrap
from typing import Any

import pytest

from harness.experiment.workers.order import read_order
from harness.experiment.workers.workers import News
from harness.record import partial_folder
from harness_plugins.kit.inspection.inspection import OUTPUT
from tests.project import ROOT

BLACK_BOX = ROOT / "examples" / "log-format" / "black_box.py"
HOOKS = """
import harness

@harness.hookimpl
def register_rewards(register):
    register("gift", __name__ + "_made:Gift", summary="a reward")
    register("twin", __name__ + "_made:Gift", summary="a reward")

@harness.hookimpl
def register_metrics(register):
    register("leaver", __name__ + "_made:Leaver", summary="a metric")
    register("twin", __name__ + "_made:Leaver", summary="a metric")

@harness.hookimpl
def register_simulators(register):
    register("mistaken", __name__ + "_made:Mistaken", summary="a simulator")

@harness.hookimpl
def register_algorithms(register):
    register("spaceless", __name__ + "_made:Spaceless", summary="an algorithm")

@harness.hookimpl
def register_commands(register):
    register("wave", __name__ + "_made:wave", summary="a command")
    register("wink", __name__ + "_made:wink", summary="a command")

@harness.hookimpl
def register_robots(register):
    register("ghost", __name__ + "_made:GHOST", summary="a robot")
"""
MADE = '''
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

GHOST = Path("/nowhere/ghost")

@dataclass(frozen=True)
class Gift:
    amount: float = 1.0

    def initial_carry(self, begin_distance):
        return ()

    def __call__(self, carry, sample):
        print("a gift")
        return carry, self.amount / (sample.previous_distance - sample.distance)

@dataclass(frozen=True)
class Leaver:
    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"

    def __call__(self, trace):
        sys.exit("no licence")

@dataclass(frozen=True)
class Mistaken:
    def open(self, robot, num_envs):
        return None

@dataclass(frozen=True)
class Spaceless:
    def train(self, env, steps, seed, progress):
        return None

def wave(times: int = 1) -> None:
    """Wave."""

def wink(eye: "NoSuch") -> None:
    """Wink."""
'''


class Here(contextlib.nullcontext[Any]):
    """Does orders in this process, which is quicker than in another. `tests/check` has what happens in another."""

    def __init__(self, environment: object) -> None:
        super().__init__(self)

    def run(self, orders, at_once):
        for given in orders:
            order, _ = read_order(given.line())
            partial_folder(order.folder).mkdir()
            with (partial_folder(order.folder) / OUTPUT).open("w") as output, contextlib.redirect_stdout(output):
                order.work.do(order.folder, lambda word: None)
            yield News("ended", order.folder)


@pytest.fixture(autouse=True)
def checked_here(monkeypatch):
    """Checks are run in this process."""
    monkeypatch.setattr("harness_plugins.kit.inspection.inspection.Pool", Here)
    monkeypatch.setattr("harness_plugins.kit.inspection.inspection.print_into", lambda path: None)


@pytest.fixture
def mine(install):
    """A package with all kinds of mistakes."""
    return install("mistakes", HOOKS, made=MADE)


def rows(out):
    """Verdict and sentence of each check in a table."""
    found = {}
    for line in out.splitlines()[:-1]:
        name, verdict, sentence = line[:28].strip(), line[28:37].strip(), line[37:].strip()
        if name:
            found[last := name] = (verdict, sentence)
        else:
            found[last] = (found[last][0], f"{found[last][1]} {sentence}")
    return found


FILES = {
    "near.py": """
        import numpy as np

        def near(step):
            return {"near": np.exp(-step.distance), "effort": -0.01 * (step.action**2).sum(-1)}
    """,
    "nearer.py": """
        from dataclasses import dataclass

        @dataclass(frozen=True)
        class Nearer:
            def initial_carry(self, begin_distance):
                return ()

            def __call__(self, carry, sample):
                return carry, -sample.distance
    """,
    "dock.py": "def dock(step):\n    return {'reach': -step.distance, 'dock': step.ground}\n",
    "bare/robot.toml": 'urdf = "gone.urdf"',
}
CHECKED = {
    "arp": (0, "reward-long-run", "ok", "reward arp: 19 ok, 0 warnings, 0 errors."),
    "near --plugin near.py": (
        *(0, "reward-numpy", "warning"),
        "xp = step.distance.__array_namespace__(), and xp.exp stands for np.exp",
    ),
    "nearer --plugin nearer.py": (0, "reward-long-run", "ok", "reward nearer: 19 ok"),
    f"black_box --plugin {BLACK_BOX} --kind log": (
        *(0, "target", "ok", "log format black_box: 22 ok, 0 warnings, 0 errors"),
    ),
    "dock --plugin dock.py": (1, "reward-terms-float", "error", "the term 'dock' is bool, not a float"),
    "mistaken": (1, "target", "error", "open takes 3 arguments beside self"),
    "spaceless": (1, "target", "error", "has no action_spaces, num_envs"),
    "wave": (0, "target", "ok", "command wave: "),
    "wink": (1, "command-options", "error", "its parameters cannot be options"),
    "twin --kind metric": (1, "target", "ok", "metric twin"),
    "twin --kind metrics": (1, "target", "ok", "metric twin"),
    "fd100": (0, "robot-loads", "ok", "robot fd100"),
    "--robot bare": (1, "robot-loads", "error", "gone.urdf"),
    "./bare": (1, "robot-loads", "error", "gone.urdf"),
    "ghost": (1, "robot-loads", "error", "ghost"),
    "fd100-reach --robot unity-arm": (0, "target", "ok", "task fd100-reach"),
    "transfer --kind section": (0, "contract", "not run", "there is no contract kit for this kind of plugin"),
}
"""By what stands behind ``harness check``: the status, a check with its verdict, and what is told."""


@pytest.mark.parametrize("line", CHECKED)
def test_what_is_checked_is_told_in_rows(mine, harness, tmp_path, line):
    """A row for each check, and how many there were; what is not of its kind is told alone, before it runs."""
    (tmp_path / "bare").mkdir()
    for name, text in FILES.items():
        (tmp_path / name).write_text(textwrap.dedent(text))
    answer, (status, check, verdict, told) = harness(f"check {line}"), CHECKED[line]
    found = rows(answer.out)
    assert (answer.status, found[check][0]) == (status, verdict), answer.out
    assert told in " ".join(answer.out.split())
    assert len(found) == 1 or (check, verdict) != ("target", "error")


def test_a_broken_reward_is_told_with_its_numbers(mine, harness):
    """Status 1; a sentence for each check that fails, and nothing that the plugin prints is among them."""
    answer = harness("check gift:amount=2")
    assert answer.status == 1
    verdict, sentence = rows(answer.out)["reward-finite-edges"]
    assert verdict == "error"
    assert sentence.startswith("the value is [")
    assert "a gift" not in answer.out
    assert "a gift" in answer.err


def test_what_raises_is_a_sentence(mine, harness):
    """With the file, the line and what the check holds; a plugin that wants to leave is held."""
    answer = harness("check leaver")
    assert answer.status == 1
    verdict, sentence = rows(answer.out)["metric-empty"]
    assert verdict == "error"
    assert sentence.startswith("raised SystemExit: no licence (")
    assert sentence.endswith("What has to hold: The value of a trace without rows is None.")
    assert "Traceback" not in answer.out + answer.err


def test_verbose_shows_the_traceback(mine, harness):
    """On standard error."""
    assert 'sys.exit("no licence")' in harness("check leaver --verbose").err


def test_a_name_of_two_kinds_takes_the_kind(mine, harness):
    """Without it, one line says which there are."""
    answer = harness("check twin")
    assert (answer.status, answer.out) == (2, "")
    assert "'twin' is a reward and a metric: add --kind reward" in answer.err


def test_json_has_the_same(harness):
    """Every check with its verdict, sentence and seconds, and nothing else on standard output."""
    told = harness("check dense --json").json
    assert (told["kind"], told["name"], told["errors"], told["warnings"]) == ("reward", "dense", 0, 0)
    assert {*told["checks"][1]} == {"check", "verdict", "sentence", "seconds"}
    assert told["ok"] == sum(check["verdict"] == "ok" for check in told["checks"])
