"""The page of old names and new names holds what the code holds, row by row."""

import re

import pytest

from harness.registry.moved import ALGORITHMS, GONE_IN, MODULES, NAMES, REPLACED
from tests.docs.pages import ROOT

PAGE = (ROOT / "docs/renamed.md").read_text(encoding="utf-8")
TABLES = {"Algorithms": ALGORITHMS, "Modules": MODULES, "Names": NAMES, "Names that no longer work": REPLACED}


def rows_of(page: str, heading: str) -> list[tuple[str, str]]:
    """The rows of the table below a heading: both cells, without backticks."""
    below = page.partition(f"\n## {heading}\n")[2].partition("\n## ")[0]
    return re.findall(r"^\| `([\w.-]+)` \| `([\w.-]+)` \|$", below, re.MULTILINE)


@pytest.mark.parametrize("heading", TABLES)
def test_table_is_that_of_the_code(heading):
    """In its order."""
    assert rows_of(PAGE, heading) == sorted(TABLES[heading].items())


def test_rows_of_another_heading_do_not_count():
    """The mutants: a row that is missing, one that says something else."""
    page = "# A\n\n## One\n\n| 0.1 | 0.2 |\n| --- | --- |\n| `a.b` | `c.d` |\n\n## Two\n\n| `e` | `f` |\n"
    assert rows_of(page, "One") == [("a.b", "c.d")]
    assert rows_of(page, "Two") == [("e", "f")]
    assert rows_of(page, "Three") == []


def test_page_says_when_old_names_go():
    """The version that the warnings say."""
    assert f"go with {GONE_IN}" in PAGE
