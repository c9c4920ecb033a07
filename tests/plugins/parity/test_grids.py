"""A parity in words and numbers."""

import re
from dataclasses import replace

import pytest

from harness_plugins.parity import Missing
from harness_plugins.parity.page import class_grid, pair_grids, response_grid, simulator_grid


@pytest.fixture(scope="module")
def lines_of(printed):
    """The lines that are printed, without blanks around them."""
    return lambda parity: [line.strip() for line in printed(parity).splitlines()]


@pytest.fixture(scope="module")
def found(compare, toolbox):
    """One that is right, one a millimetre off, one that feels nothing."""
    return compare(right=toolbox.ideal, off=toolbox.shifted_tip(1e-3), numb=toolbox.numb)


@pytest.fixture(scope="module")
def late(compare, toolbox):
    """One that is right, one whose tip is a millimetre off, one that is a period late."""
    return compare(right=toolbox.ideal, off=toolbox.shifted_tip(1e-3), late=toolbox.late)


def test_the_first_lines_say_what_was_compared(found, lines_of):
    """All names, how much was driven, and the largest distances to the reference, in millimetres."""
    assert lines_of(found)[:4] == [
        "right / off / numb · fd100",
        "3 smooth motions of 40 control periods of 0.1 s, 3 dives to the ground, seed 0",
        "",
        "Largest distance of the tip from right's: 1 mm (off), 0 mm (numb)",
    ]


@pytest.mark.parametrize(
    ("families", "told"),
    [
        (("MuJoCo", "Bullet", "MuJoCo"), "Independent engines: MuJoCo (right, numb: one vote), Bullet (off)."),
        ((None, "Drake", None), "Independent engines: Drake (off). No engine: right, numb."),
        ((None, None, None), "Independent engines: none. No engine: right, off, numb."),
    ],
)
def test_simulators_of_one_engine_are_one_vote(found, families, told, lines_of):
    """Each engine with its simulators; those without an engine apart."""
    pairs = zip(found.simulators, families, strict=True)
    assert told in lines_of(replace(found, simulators=[replace(one, family=family) for one, family in pairs]))


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


def test_one_simulator_is_nothing_to_compare(compare, toolbox, lines_of):
    """Its own errors are shown all the same."""
    alone = compare(one=toolbox.ideal)
    assert any(line.startswith("Nothing to compare") for line in lines_of(alone))
    assert (pair_grids(alone), len(simulator_grid(alone).rows)) == ([], 1)


def test_failed_and_missing_are_told(compare, toolbox, lines_of):
    """Why, and what to type; a reference that failed is said to have."""
    missing = [Missing("far", "away", "pip install far")]
    broken = compare(missing, bad=toolbox.closed, one=toolbox.ideal, two=toolbox.late)
    lines = lines_of(broken)
    assert lines[-2:] == ["failed: bad: MemoryError", "not installed: far: pip install far"]
    assert "The reference bad failed; the others are compared with one another" in lines
    assert [grid.headings[0] for grid in pair_grids(broken)] == ["the others"]


def test_without_dives_none_are_told(compare, toolbox, robot, lines_of):
    """The reason is in a note, the share is n/a."""
    stiff = replace(robot, lower=robot.home - 0.05, upper=robot.home + 0.05)
    found = compare(arm=stiff, one=toolbox.ideal, two=toolbox.ideal)
    assert "dives" not in lines_of(found)[1]
    (grid,) = pair_grids(found)
    assert grid.rows[0][-2:] == ("n/a", "n/a")
    assert grid.notes[0] == "two: no part of the arm was found to get into the ground."


def test_the_terminal_shows_it_all(found, printed):
    """In 80 columns, no value cut off."""
    text = printed(found, 80)
    for row in [row for grid in (*pair_grids(found), simulator_grid(found)) for row in grid.rows]:
        assert re.search(r"\s+".join(map(re.escape, row)), text)
    assert "…" not in text


def test_a_simulator_that_lacks_solids_is_named_with_them(found, compare, toolbox, lines_of, printed):
    """With the dives that each feels, and no explanation of where its joints are in them; else nothing is said."""
    told = "Dives that touch the ground: "
    (line,) = (line for line in lines_of(found) if line.startswith(told))
    assert line.startswith(f"{told}3 of 3 in right, off; 0 of 3 in numb. numb has no solid for links ")
    assert "'tool0' (cylinder)" in line
    notes = class_grid(found, list(found.pairs)).notes
    assert any(line.startswith("numb: numb has no solid for links ") for line in notes)
    assert not any(line.startswith("numb, contact") for line in notes)
    assert told not in printed(compare(one=toolbox.ideal, two=toolbox.ideal))


def test_every_class_is_a_row(late, lines_of):
    """Of each pair with the reference; the others have both names. Each class is told in words."""
    rows = class_grid(late, list(late.pairs[:2])).rows
    classes = ("slow", "smooth", "fast", "singular", "contact")
    assert [row[0] for row in rows] == [f"{name}: {kind}" for name in ("off", "late") for kind in classes]
    assert rows[0][1:3] == ("1", "1")
    assert class_grid(late, [late.pairs[2]]).rows[0][0] == "late against off: slow"
    told = "slow: up to 20% of the speed and 10% of the acceleration; smooth: up to 80% and 60%"
    assert any(line.startswith(told) and "smallest singular value" in line for line in lines_of(late))


def test_what_explains_a_difference_is_told(late, compare, toolbox):
    """Who is off, who is late and by how much, and where; who is too slow. A hundredth of a millimetre needs none."""
    notes = {line.partition(":")[0]: line for line in class_grid(late, list(late.pairs[:2])).notes}
    assert "off is up to 1 mm from where it is told to be, right 0 mm" in notes["off, slow"]
    assert "late is 100 ms behind right, which explains 100%" in notes["late, slow"]
    assert "s into a motion, where joint" in notes["late, fast"]
    assert "late is slower than told in" in notes["late, fast"]
    assert "after the first contact" in notes["late, contact"]
    near = compare(right=toolbox.ideal, off=toolbox.shifted_tip(1e-5))
    assert len(class_grid(near, list(near.pairs)).notes) == 1


def test_each_simulator_says_how_it_follows(late):
    """A row for each class."""
    rows = {row[0]: row[1:] for row in response_grid(late).rows}
    assert rows["right: fast"] == ("0", "100%", "100%", "0.0%", "0")
    assert float(rows["late: smooth"][4]) == pytest.approx(100.0, rel=0.1)
    assert len(rows) == 15
