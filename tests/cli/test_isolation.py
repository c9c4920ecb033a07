"""What one package does wrong costs its own rows, in every command."""

import pyarrow.parquet as pq
import pytest

HOOKS = """
import harness

@harness.hookimpl
def register_metrics(register):
    register("sick", f"{__name__}_code:Sick", summary="raises")

@harness.hookimpl
def register_rewards(register):
    register("ill", f"{__name__}_code:Ill", summary="raises")

@harness.hookimpl
def register_commands(register):
    register("trip", f"{__name__}_code:trip", summary="raises")

@harness.hookimpl
def register_algorithms(register):
    register("cem", f"{__name__}_code:Cem", summary="lacks something")
    register("odd", f"{__name__}_code:Odd", summary="raises when it is planned")
"""
CODE = """
from dataclasses import dataclass

@dataclass(frozen=True)
class Sick:
    unit = ""
    better = "higher"
    def __call__(self, trace):
        return trace.no_such

@dataclass(frozen=True)
class Ill:
    def initial_carry(self, begin_distance):
        return {}["no_such"]
    def __call__(self, carry, sample):
        return carry, sample.distance

@dataclass(frozen=True)
class Cem:
    num_envs: int = 1
    def train(self, env, steps, seed, progress):
        pass

@dataclass(frozen=True)
class Odd(Cem):
    action_spaces = frozenset({"continuous"})
    def why_not(self, task, robot):
        return task.no_such

def trip(far: int = 1):
    raise LookupError("a cable")
"""


@pytest.fixture
def odd(install):
    """A package in which everything is wrong."""
    return install("odd", HOOKS, code=CODE)


@pytest.fixture
def experiment(finished, odd):
    """A finished experiment, and then the package."""
    return finished(seeds=1)


SICK = "metric sick: n/a (AttributeError: "


def test_run_goes_on(harness, quick, odd, tmp_path):
    """A metric that raises has no values; the run, its table and its page are there."""
    answer = harness("run --reward arp --seeds 1 --out mine", *quick)
    assert answer.status == 0
    assert SICK in answer.err
    row = pq.read_table(tmp_path / "mine" / "results.parquet").to_pylist()[0]
    assert (row["sick"], row["success_rate"]) == (None, 0.0)
    assert row["not_measured"].startswith("sick: AttributeError")
    assert "n/a (AttributeError" in (tmp_path / "mine" / "report.html").read_text()


def test_report_goes_on(harness, experiment):
    """In the terminal, in JSON, and with the metrics that were chosen."""
    answer = harness("report mine --details")
    assert (answer.status, SICK in answer.err) == (0, True)
    assert "n/a" in answer.out
    assert "sick" in harness("report mine --json").json["not_measured"]
    chosen = harness("report mine --json --metric work")
    assert chosen.err == ""
    names = {it["name"] for it in chosen.json["combinations"][0]["behaviour"]}
    assert names == {"success_rate", "time_to_target", "work"}


def test_score_goes_on(harness, experiment, tmp_path):
    """The reward that raises has no row and no column; the others have theirs, and the status tells."""
    answer = harness("score mine --reward ill,dense --json")
    assert answer.status == 1
    assert "reward ill: n/a (KeyError: 'no_such')" in answer.err
    (matrix,) = answer.json["matrices"]
    assert list(matrix["indices"]) == ["dense"]
    assert "KeyError: 'no_such'" in matrix["failed"]["ill"]
    assert pq.read_table(next((tmp_path / "mine" / "cells").glob("*/scores.parquet"))).column_names == ["dense"]
    assert "n/a (" in harness("score mine --reward ill").out


def test_audit_names_the_package(harness, odd):
    """Of the reward that raises; the other one can be audited."""
    answer = harness("audit --reward ill --episodes 2 --budget 0")
    assert answer.status == 1
    assert "Reward 'ill' of package odd 1.0 raised KeyError: 'no_such' while it was audited" in answer.err
    other = harness("audit --reward arp --against ill --episodes 2 --budget 0")
    assert "Reward 'ill' of package odd 1.0 raised" in other.err
    assert harness("audit --reward arp --episodes 2 --budget 0").status == 0


def test_transfer_goes_on(harness, experiment, transferred_here):
    """What was evaluated elsewhere is told without the metric."""
    answer = harness("transfer mine --to stuck")
    assert answer.status == 0
    assert "stuck" in answer.out


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("cem", "Algorithm 'cem' of package odd 1.0 has no action_spaces; an algorithm has action_spaces, num_envs"),
        ("odd", "Algorithm 'odd' of package odd 1.0 raised AttributeError: "),
    ],
)
def test_planning_tells_whose_fault_it_is(harness, odd, name, told):
    """In one line; nothing is written."""
    answer = harness("run --sim ideal --algo", name, "--steps", "12", "--out", "new", "--dry-run")
    assert answer.status == 1
    assert told in answer.err
    assert answer.err.count("\n") == 1


def test_command_that_raises_is_its_package_s_fault(harness, odd):
    """With a log for its authors; a wrong option is the user's."""
    answer = harness("trip")
    assert answer.status == 1
    assert (
        "Command 'trip' of package odd 1.0 raised LookupError: a cable. Report it to its authors with the log, "
        in answer.err
    )
    assert harness("trip --near 2").status == 2


def test_reward_that_raises_fails_its_own_cells(harness, odd, quick):
    """The baseline's are done."""
    answer = harness("run --reward ill --seeds 1 --out mine --json", *quick)
    assert answer.status == 1
    cells = {cell["reward"]: cell for cell in answer.json["cells"]}
    assert (cells["baseline"]["status"], cells["ill"]["status"]) == ("done", "failed")
    assert cells["ill"]["reason"] == "KeyError: 'no_such'"
