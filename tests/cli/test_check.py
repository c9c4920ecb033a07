"""`harness check`: a verdict and a sentence for every check, whatever the plugin does."""

import contextlib
import inspect
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from harness.experiment import Order
from harness.experiment.workers.order import read_order
from harness.experiment.workers.workers import News
from harness.record import partial_folder
from harness_plugins.kit.inspection.inspection import OUTPUT

BLACK_BOX = Path(__file__).parents[2] / "examples" / "log-format" / "black_box.py"
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

    def run(self, orders: Sequence[Order], at_once: int) -> Iterator[News]:
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


def rows(out: str) -> dict[str, tuple[str, str]]:
    """Verdict and sentence of each check in a table."""
    found: dict[str, tuple[str, str]] = {}
    for line in out.splitlines()[:-1]:
        name, verdict, sentence = line[:28].strip(), line[28:37].strip(), line[37:].strip()
        if name:
            found[last := name] = (verdict, sentence)
        else:
            found[last] = (found[last][0], f"{found[last][1]} {sentence}")
    return found


def test_a_sound_reward_passes(harness):
    """Status 0, a row for each check, and how many there were."""
    answer = harness("check", "arp")
    assert answer.status == 0
    found = rows(answer.out)
    assert found["target"] == ("ok", "")
    assert found["reward-no-event"] == ("ok", "")
    assert found["reward-long-run"] == ("ok", "")
    assert answer.out.splitlines()[-1].startswith("reward arp: 19 ok, 0 warnings, 0 errors.")


def test_a_plain_function_that_uses_numpy_is_warned_of(harness, tmp_path):
    """Status 0: it trains; the sentence says what JAX needs instead."""
    made = """
        import numpy as np

        def near(step):
            return {"near": np.exp(-step.distance), "effort": -0.01 * (step.action**2).sum(-1)}
    """
    (tmp_path / "near.py").write_text(inspect.cleandoc(made))
    answer = harness("check", "near", "--plugin", "near.py")
    assert answer.status == 0, answer.out
    verdict, sentence = rows(answer.out)["reward-numpy"]
    assert verdict == "warning"
    assert "xp = step.distance.__array_namespace__(), and xp.exp stands for np.exp" in sentence
    assert answer.out.splitlines()[-1].startswith("reward near: 18 ok, 1 warning, 0 errors.")


def test_a_term_that_is_no_float_is_an_error(harness, tmp_path):
    """The sentence names the term."""
    (tmp_path / "dock.py").write_text("def dock(step):\n    return {'reach': -step.distance, 'dock': step.ground}\n")
    answer = harness("check", "dock", "--plugin", "dock.py")
    assert answer.status == 1
    assert rows(answer.out)["reward-terms-float"] == ("error", "the term 'dock' is bool, not a float")


@pytest.mark.usefixtures("mine")
def test_a_broken_reward_is_told_with_its_numbers(harness):
    """Status 1; a sentence for each check that fails, and nothing that the plugin prints is among them."""
    answer = harness("check", "gift:amount=2")
    assert answer.status == 1
    verdict, sentence = rows(answer.out)["reward-finite-edges"]
    assert verdict == "error"
    assert sentence.startswith("the value is [")
    assert "a gift" not in answer.out
    assert "a gift" in answer.err


@pytest.mark.usefixtures("mine")
def test_what_raises_is_a_sentence(harness):
    """With the file, the line and what the check holds; a plugin that wants to leave is held."""
    answer = harness("check", "leaver")
    assert answer.status == 1
    verdict, sentence = rows(answer.out)["metric-empty"]
    assert verdict == "error"
    assert sentence.startswith("raised SystemExit: no licence (")
    assert sentence.endswith("What has to hold: The value of a trace without rows is None.")
    assert "Traceback" not in answer.out + answer.err


@pytest.mark.usefixtures("mine")
def test_verbose_shows_the_traceback(harness):
    """On standard error."""
    assert 'sys.exit("no licence")' in harness("check", "leaver", "--verbose").err


@pytest.mark.usefixtures("mine")
@pytest.mark.parametrize(
    ("name", "words"),
    [("mistaken", "open takes 3 arguments beside self"), ("spaceless", "has no action_spaces, num_envs")],
)
def test_what_is_not_of_its_kind_is_told_before_it_runs(harness, name, words):
    """One row, which names the package and what is missing."""
    answer = harness("check", name)
    assert answer.status == 1
    verdict, sentence = rows(answer.out)["target"]
    assert verdict == "error"
    assert words in sentence
    assert len(rows(answer.out)) == 1


@pytest.mark.usefixtures("mine")
def test_a_command_is_checked_too(harness):
    """Its parameters have to be what typer makes options of."""
    assert harness("check", "wave").status == 0
    answer = harness("check", "wink")
    assert answer.status == 1
    assert "its parameters cannot be options" in rows(answer.out)["command-options"][1]


@pytest.mark.usefixtures("mine")
def test_a_name_of_two_kinds_takes_the_kind(harness):
    """Without it, one line says which there are; plural or singular, as one likes."""
    answer = harness("check", "twin")
    assert (answer.status, answer.out) == (2, "")
    assert "'twin' is a reward and a metric: add --kind reward" in answer.err
    assert harness("check", "twin", "--kind", "metric").out.splitlines()[-1].startswith("metric twin")
    assert harness("check", "twin", "--kind", "metrics").out.splitlines()[-1].startswith("metric twin")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "nothing to check: type harness check NAME"),
        (["arpp"], "Did you mean 'arp'?"),
        (["arp", "--kind", "rewrd"], "Did you mean 'reward'?"),
        (["arp", "--kind", "metric"], "No metric 'arp'"),
        (["arp:k9=1"], "has no parameter 'k9'"),
        (["arp", "--robot", "fd100"], "reward 'arp' is checked without a robot"),
    ],
)
def test_what_cannot_be_checked_is_a_usage_error(harness, arguments, words):
    """One line, status 2."""
    answer = harness("check", *arguments)
    assert (answer.status, answer.out) == (2, "")
    assert words in answer.err
    assert answer.err.count("\n") == 1


def test_a_single_file_is_checked(harness, tmp_path):
    """By --plugin, without an installation."""
    made = """
        from dataclasses import dataclass

        @dataclass(frozen=True)
        class Nearer:
            def initial_carry(self, begin_distance):
                return ()

            def __call__(self, carry, sample):
                return carry, -sample.distance
    """
    (tmp_path / "nearer.py").write_text(inspect.cleandoc(made))
    answer = harness("check", "nearer", "--plugin", "nearer.py")
    assert answer.status == 0, answer.out
    assert answer.out.splitlines()[-1].startswith("reward nearer: 19 ok")


def test_a_log_format_is_checked_by_the_word_of_its_kind(harness):
    """Its noun has two words, of which one is typed; each check has an empty folder."""
    answer = harness("check", "black_box", "--plugin", str(BLACK_BOX), "--kind", "log")
    assert answer.status == 0, answer.out
    assert answer.out.splitlines()[-1].startswith("log format black_box: 22 ok, 0 warnings, 0 errors")


def test_json_has_the_same(harness):
    """Every check with its verdict, sentence and seconds, and nothing else on standard output."""
    told = json.loads(harness("check", "dense", "--json").out)
    assert (told["kind"], told["name"], told["errors"], told["warnings"]) == ("reward", "dense", 0, 0)
    assert {*told["checks"][1]} == {"check", "verdict", "sentence", "seconds"}
    assert told["ok"] == sum(check["verdict"] == "ok" for check in told["checks"])


def test_a_robot_is_checked_by_name_or_by_its_files(harness, tmp_path):
    """As an argument, or by --robot; what cannot be read is a row of its own."""
    assert harness("check", "fd100").status == 0
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "robot.toml").write_text('urdf = "gone.urdf"')
    for arguments in (["--robot", "mine"], ["./mine"]):
        answer = harness("check", *arguments)
        assert answer.status == 1
        verdict, sentence = rows(answer.out)["robot-loads"]
        assert verdict == "error"
        assert "gone.urdf" in sentence


@pytest.mark.usefixtures("mine")
def test_a_robot_that_is_not_there_is_told(harness):
    """Its plugin named a folder that does not exist."""
    answer = harness("check", "ghost")
    assert answer.status == 1
    assert "ghost" in rows(answer.out)["robot-loads"][1]


def test_a_task_is_checked_with_another_robot(harness):
    """By its name."""
    answer = harness("check", "fd100-reach", "--robot", "unity-arm")
    assert answer.status == 0


@pytest.mark.usefixtures("mine")
def test_plugins_check_finds_what_is_broken(harness):
    """Status 1, with what is wrong under the plugin's name; without --check nothing is imported."""
    assert harness("plugins").status == 0
    answer = harness("plugins", "--check")
    assert answer.status == 1
    (line,) = [line for line in answer.out.splitlines() if "Simulator 'mistaken'" in line]
    assert "Algorithm 'spaceless'" in line
    assert "Robot 'ghost'" in line
    assert "Reward 'gift'" not in line


def test_kind_without_a_kit_is_told(harness):
    """In one line, after its members were looked at."""
    answer = harness("check", "transfer", "--kind", "section")
    assert answer.status == 0
    words = "there is no contract kit for this kind of plugin: test what it does in its own package"
    assert rows(answer.out) == {"target": ("ok", ""), "contract": ("not run", words)}
