"""The checks together: their names, their words, their levels, and how many ways to be wrong they catch."""

import re

from harness.hookspecs import KINDS
from harness_plugins.kit.contract import Check
from harness_plugins.kit.kits import KITS
from tests.project import ROOT

from .test_mutants import ROWS

DOCS = ROOT / "docs" / "contracts.md"
PREFIXES = {"simulators": "sim-", "algorithms": "algo-"}
"""Of the others it is their kind."""
SHARED = {"settings-frozen", "settings-json"}


def test_names_begin_with_their_kind():
    """But for the two that all kinds share; and no two checks of a kind have one name."""
    for kind, kit in KITS.items():
        names = [check.name for check in kit.checks]
        assert len({*names}) == len(names)
        assert all(name.startswith(PREFIXES.get(kind, f"{kind.removesuffix('s')}-")) for name in {*names} - SHARED)


def test_a_check_has_a_name_and_a_fact():
    """As a function is called, so that pytest names the test of a check by it; the fact is for authors of plugins."""
    for kit in KITS.values():
        assert [check.__name__ for check in kit.checks] == [check.name for check in kit.checks]
        assert [check.name for check in kit.checks if len(check.fact) < 35] == []
    assert Check.__name__ == "Check"


def test_kinds_that_people_write_have_a_kit():
    """A command does whatever it likes; the others are filled by what is built in."""
    assert set(KINDS) - set(KITS) == {"commands", "descriptions", "screens", "sections"}


def test_levels_are_those_of_their_place():
    """The contract is made of errors, advice of warnings."""
    for kit in KITS.values():
        assert {check.level for check in (*kit.contract, *kit.long)} == {"error"}
        assert {check.level for check in kit.advice} <= {"warning"}


def test_the_page_tells_how_many_mutants_are_caught():
    """Each is a test of its own."""
    told = re.search(r"catch (\d+) planted mistakes", DOCS.read_text(encoding="utf-8"))
    assert told
    assert int(told[1]) == sum(map(len, ROWS.values()))
