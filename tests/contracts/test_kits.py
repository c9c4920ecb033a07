"""The checks together: their names, their levels, their page in the docs, and how many ways to be wrong they catch."""

import ast
import re
from pathlib import Path

import pytest

from harness.hookspecs import KINDS
from harness_plugins.kit.contract import Check
from harness_plugins.kit.kits import KITS

DOCS = Path(__file__).parents[2] / "docs" / "contracts.md"
PREFIXES = {
    "simulators": "sim-", "algorithms": "algo-", "rewards": "reward-", "metrics": "metric-", "tasks": "task-",
    "robots": "robot-", "environments": "environment-", "logs": "log-",
}  # fmt: skip
SHARED = ("settings-frozen", "settings-json")
ALL = {check.name: check for kit in KITS.values() for check in kit.checks}
TABLES = ("MUTANTS", "COARSE_MUTANTS", "FOUND", "WRONG")
"""What the modules of mutants call the tables of them, each of which is a test."""
MUTANT_MODULES = "algorithm checkpoint environment log long_run metric reward robot servo simulator speed task"


def test_names_begin_with_their_kind(subtests: pytest.Subtests):
    """But for the two that all kinds share; and no two checks of a kind have one name."""
    for kind in KITS:
        with subtests.test(kind=kind):
            names = [check.name for check in KITS[kind].checks]
            assert len(set(names)) == len(names)
            assert all(name in SHARED or name.startswith(PREFIXES[kind]) for name in names)


def test_a_check_is_called_by_its_name():
    """As a function is, so that pytest names the test of a check by it; the class keeps its own."""
    assert [check.__name__ for check in ALL.values()] == list(ALL)
    assert Check.__name__ == "Check"


def test_kinds_that_people_write_have_a_kit():
    """A command does whatever it likes; the others are filled by what is built in."""
    assert set(KINDS) - set(KITS) == {"commands", "descriptions", "executors", "screens", "sections", "trackers"}


def test_levels_are_those_of_their_place():
    """The contract is made of errors, advice of warnings."""
    for kit in KITS.values():
        assert {check.level for check in (*kit.contract, *kit.long)} == {"error"}
        assert {check.level for check in kit.advice} <= {"warning"}


def test_the_kit_catches_at_least_sixty_mutants():
    """As the page says; each is a test of its own in the modules of mutants."""
    folder = Path(__file__).parent
    modules = [folder / f"test_{name}_mutants.py" for name in MUTANT_MODULES.split()]
    assert sorted(folder.glob("test_*_mutants.py")) == sorted(modules)
    counted = sum(map(_mutants_in, modules))
    told = re.search(r"catch (\d+) planted mistakes", DOCS.read_text(encoding="utf-8"))
    assert told
    assert counted == int(told[1])
    assert counted >= 60


def _mutants_in(module: Path) -> int:
    """Entries of the tables of mutants in a module."""
    count = 0
    for node in ast.parse(module.read_text(encoding="utf-8")).body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        if any(isinstance(target, ast.Name) and target.id in TABLES for target in targets):
            value = node.value
            count += len(value.keys if isinstance(value, ast.Dict) else value.elts)
    return count
