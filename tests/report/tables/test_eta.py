"""Recorded runs compared, as a terminal shows it."""

from dataclasses import replace

import pytest

from harness.report import FactsTable, eta_facts, scales_text
from harness.report.rows.ratios import index_grid, ratio_grid, split_grid
from tests.report import conftest


def printed(comparison, *console, **given):
    """What goes to a terminal."""
    return conftest.printed(FactsTable(eta_facts(comparison)), *console, **given)


@pytest.mark.parametrize("width", [60, 80])
def test_every_number_stands_whole(compare, width):
    """Both etas, their parts and the indices, below the number in words."""
    comparison = compare()
    text = printed(comparison, width)
    squeezed = " ".join(text.split())
    assert squeezed.index(comparison.number) < squeezed.index("proposed / baseline")
    splits = comparison.decomposition.splits
    for grid in (ratio_grid(splits), split_grid(splits), index_grid(comparison.decomposition)):
        assert all(value in text for row in grid.rows for value in row[1:])
    assert scales_text("robot") in squeezed
    assert max(map(len, text.splitlines())) <= width


def test_title_names_both_rewards(compare):
    """As they were found out; without distances nobody knows."""
    assert printed(compare()).startswith("proposed arp:k1=1,k2=1.5 against baseline\n")
    unknown = "proposed an unknown reward against an unknown reward\n"
    assert printed(compare(columns=1)).startswith(unknown)


def test_runs_without_distances_are_not_split(compare):
    """The etas and the indices stand, and the file that has none is named."""
    text = printed(compare(columns=1), width=400)  # no path is broken
    assert "eta_N" in text
    assert "interaction" not in text
    assert "0.csv has no distances" in " ".join(text.split())


def test_runs_are_counted(compare):
    """With the rows that are not compared, and whether the event terms are."""
    comparison = compare()
    assert "\nbaseline 2 runs, proposed 2 runs\n" in printed(comparison)
    cut = replace(comparison, runs={"baseline": 1, "proposed": 2_000}, rows_left_out={"baseline": 0, "proposed": 1})
    assert "\nbaseline 1 run, proposed 2,000 runs (1 row behind the shortest run left out)\n" in printed(cut, 100)
    assert "event terms included\n" in printed(replace(comparison, with_events=True))


def test_heading_says_which_curve(compare):
    """The indices of the per-step curve are others."""
    assert "per-step reward" in printed(compare(kind="per-step"))
    assert "accumulated reward" in printed(compare())


def test_names_are_no_markup(compare):
    """A reward's label may hold brackets."""
    given = replace(compare(), rewards={"baseline": "[bold]base[/bold]", "proposed": "arp"})
    assert "[bold]base[/bold]" in printed(given)
