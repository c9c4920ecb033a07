"""A parity in words and numbers."""

import io
import re
from dataclasses import replace

import pytest
from rich.console import Console

from harness_plugins.parity import Missing, parity_table
from harness_plugins.parity.page import (
    contact_text,
    engines_text,
    explanations,
    failures,
    not_installed,
    pair_grids,
    setting_text,
    simulator_grid,
    title,
    verdict,
)


@pytest.fixture(scope="module")
def found(compare, toolbox):
    """One that is right, one a millimetre off, one that feels nothing."""
    return compare(right=toolbox.ideal, off=toolbox.shifted_tip(1e-3), numb=toolbox.numb)


def test_the_verdict_names_the_largest_distances(found):
    """To the reference, in millimetres."""
    assert verdict(found) == "Largest distance of the tip from right's: 1 mm (off), 0 mm (numb)"


def test_simulators_of_one_engine_are_one_vote(found):
    """Each engine with its simulators; those without an engine apart."""

    def told(*families):
        pairs = zip(found.simulators, families, strict=True)
        return engines_text(replace(found, simulators=[replace(one, family=family) for one, family in pairs]))

    assert told("MuJoCo", "Bullet", "MuJoCo") == "Independent engines: MuJoCo (right, numb: one vote), Bullet (off)."
    assert told(None, "Drake", None) == "Independent engines: Drake (off). No engine: right, numb."
    assert told(None, None, None) == "Independent engines: none. No engine: right, off, numb."


def test_the_title_names_all(found):
    """And the line below says how much was driven."""
    assert title(found) == "right / off / numb · fd100"
    told = "3 smooth motions of 40 control periods of 0.1 s, 3 dives to the ground, seed 0"
    assert setting_text(found) == told


def test_the_reference_has_a_table_of_its_own(found):
    """Then the others; the explanation once, at the end."""
    first, others = pair_grids(found)
    assert first.headings[0] == "against right"
    assert [row[0] for row in first.rows] == ["off", "numb"]
    assert first.rows[0][1:] == ("1", "1", "0", "0.0%", "0")
    assert first.rows[1][-1] == "n/a"
    assert first.notes == ["numb: of 3 dives, 3 in the first alone touch the ground."]
    assert [row[0] for row in others.rows] == ["numb against off"]
    assert others.notes[-1].startswith("Tip, joint:")


def test_each_simulator_has_a_row(found):
    """Its own errors in mm and deg, its cost in ms."""
    grid = simulator_grid(found)
    assert [row[0] for row in grid.rows] == ["right", "off", "numb"]
    assert grid.rows[1][1:5] == ("1", "0", "1", "0")
    assert 0.0 < float(grid.rows[0][5]) < 100.0


def test_one_simulator_is_nothing_to_compare(compare, toolbox):
    """Its own errors are shown all the same."""
    alone = compare(one=toolbox.ideal)
    assert verdict(alone).startswith("Nothing to compare")
    assert pair_grids(alone) == []
    assert len(simulator_grid(alone).rows) == 1


def test_failed_and_missing_are_told(compare, toolbox):
    """Why, and what to type; a reference that failed is said to have."""
    missing = [Missing("far", "away", "pip install far")]
    broken = compare(missing, bad=toolbox.closed, one=toolbox.ideal, two=toolbox.late)
    assert failures(broken) == ["failed: bad: MemoryError"]
    assert not_installed(broken) == ["not installed: far: pip install far"]
    assert verdict(broken) == "The reference bad failed; the others are compared with one another"
    assert [grid.headings[0] for grid in pair_grids(broken)] == ["the others"]


def test_without_dives_none_are_told(compare, toolbox, robot):
    """The reason is in a note, the share is n/a."""
    stiff = replace(robot, lower=robot.home - 0.05, upper=robot.home + 0.05)
    found = compare(arm=stiff, one=toolbox.ideal, two=toolbox.ideal)
    assert "dives" not in setting_text(found)
    (grid,) = pair_grids(found)
    assert grid.rows[0][-2:] == ("n/a", "n/a")
    assert grid.notes[0] == "two: no part of the arm was found to get into the ground."


def test_the_terminal_shows_it_all(found):
    """In 80 columns, no value cut off."""
    console = Console(width=80, file=io.StringIO())
    console.print(parity_table(found))
    text = console.file.getvalue()
    for row in [row for grid in (*pair_grids(found), simulator_grid(found)) for row in grid.rows]:
        assert re.search(r"\s+".join(map(re.escape, row)), text)
    assert "…" not in text


def test_a_simulator_that_lacks_solids_is_named_with_them(found):
    """With the dives that each feels, and no explanation of where its joints are in them."""
    told = contact_text(found)
    assert told.startswith(
        "Dives that touch the ground: 3 of 3 in right, off; 0 of 3 in numb. numb has no solid for links "
    )
    assert "'tool0' (cylinder)" in told
    lines = explanations(found, list(found.pairs))
    assert any(line.startswith("numb: numb has no solid for links ") for line in lines)
    assert not any(line.startswith("numb, contact") for line in lines)


def test_where_all_feel_every_dive_nothing_is_said(compare, toolbox):
    """Contact that is alike needs no line."""
    assert contact_text(compare(one=toolbox.ideal, two=toolbox.ideal)) == ""
