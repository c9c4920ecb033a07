"""Every check of the contract kit has something broken that fails it, and passes what that was made of."""

from dataclasses import dataclass

import pytest

from harness_plugins.kit.contract import violations
from harness_plugins.kit.kits import KITS

from .mutants import algorithms, environments, executors, logs, metrics, rewards, robots, simulators, tasks, trackers

MODULES = {
    "algorithms": algorithms,
    "environments": environments,
    "executors": executors,
    "logs": logs,
    "metrics": metrics,
    "rewards": rewards,
    "robots": robots,
    "simulators": simulators,
    "tasks": tasks,
    "trackers": trackers,
}
BESIDE = {"simulators": (simulators.ROBOT,), "tasks": (tasks.ROBOT,)}
"""What the checks of a kind take beside the plugin."""


@dataclass
class Thawed:
    """Its settings can be changed while it runs."""


@dataclass(frozen=True)
class SetUpWithASet:
    """JSON knows no sets."""

    zones: frozenset[int] = frozenset({1})


SHARED = {"thawed": ("settings-frozen", Thawed()), "with a set": ("settings-json", SetUpWithASet())}
"""Of every kind but robots, which have no settings."""
ROWS = {kind: {**({} if kind == "robots" else SHARED), **module.MUTANTS} for kind, module in MODULES.items()}


def sentences(kind, checks, plugin, folder):
    """What is said of a plugin, each check in a folder of its own where it takes one."""
    found = list[str]()
    for check in checks:
        (own := folder / check.name).mkdir()
        beside = (own,) if kind in {"logs", "executors", "trackers"} else BESIDE.get(kind, ())
        found += [violation.sentence for violation in violations([check], plugin, *beside)]
    return found


@pytest.fixture
def quicker(monkeypatch):
    """What is slow or grows shows in shorter trials: mutants break bounds by several times as much."""
    for name, value in {"LEARNING_STEPS": 20, "MOST_DRAW": 2e-3, "MOST_METRIC": 0.05}.items():
        monkeypatch.setattr(f"harness_plugins.kit.kits.{name}", value)
    monkeypatch.setattr("harness_plugins.kit.simulators.calls.STEPS", 1_500)
    yield
    for kept in (rewards.SAMPLES, rewards.WORDS, simulators.LEAKED):
        kept.clear()


@pytest.mark.usefixtures("quicker")
@pytest.mark.parametrize(("kind", "name"), [(kind, name) for kind, rows in ROWS.items() for name in rows])
def test_mutant_fails_its_check(kind, name, tmp_path):
    """By what the check says; where an exception is the right end, the row has its words."""
    named, plugin, *words = ROWS[kind][name]
    check = next(check for check in KITS[kind].checks if check.name == named)
    (sentence,) = sentences(kind, [check], plugin, tmp_path)
    assert (words or [""])[0] in sentence
    assert words or not sentence.startswith("raised")


@pytest.mark.usefixtures("quicker")
@pytest.mark.parametrize(("kind", "number"), [(kind, it) for kind in MODULES for it in range(len(MODULES[kind].SOUND))])
def test_what_mutants_are_made_of_fails_nothing(kind, number, tmp_path):
    """No check of its kind."""
    kit = KITS[kind]
    assert sentences(kind, (*kit.contract, *kit.long), MODULES[kind].SOUND[number], tmp_path) == []


@pytest.mark.parametrize("kind", ["simulators", "rewards", "tasks"])
def test_nothing_is_told_of_what_is_quick(kind, tmp_path, monkeypatch):
    """With bounds that a busy machine keeps."""
    for name in ("MOST_STEP", "MOST_REWARD", "MOST_DRAW"):
        monkeypatch.setattr(f"harness_plugins.kit.kits.{name}", 1.0)
    assert sentences(kind, KITS[kind].advice[-1:], MODULES[kind].SOUND[0], tmp_path) == []


def test_numpy_is_an_error_in_a_class_and_a_warning_in_a_plain_function():
    """Which trains as it is; the check says what JAX needs. Of other plain functions nothing is said."""
    kit = KITS["rewards"]
    for reward, expected in (
        (rewards.MUTANTS["numpy"][1], ["reward-array-library"]),
        (rewards.MUTANTS["numpy in a plain function"][1], ["reward-numpy"]),
        *((reward, []) for reward in rewards.SOUND),
    ):
        found = violations((*kit.contract, *kit.advice[:-1]), reward)
        assert [violation.check for violation in found if violation.check != "reward-leak"] == expected


@pytest.mark.parametrize("tells", [True, False])
def test_a_right_policy_acts_as_it_trained(tells, tmp_path):
    """That of a real learner, as it is."""
    checks = [
        check for check in KITS["algorithms"].contract if check.name in ("algo-acts-as-trained", "algo-policy-box")
    ]
    assert sentences("algorithms", checks, algorithms.Exporting(algorithms.as_it_is, tells), tmp_path) == []


def test_every_check_has_a_mutant():
    """Each of each kind, warnings too; that simulators have all solids of a robot is tested with the robots."""
    without = {
        (kind, check.name)
        for kind, kit in KITS.items()
        for check in kit.checks
        if check.name not in {row[0] for row in ROWS[kind].values()}
    }
    assert without == {("robots", "robot-simulators")}
