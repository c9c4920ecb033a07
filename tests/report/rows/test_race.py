"""A race for the best reward, as the terminal and the page show it."""

import re
from dataclasses import replace

import pytest

from harness.record import Terms
from harness.registry import load_registry
from harness.report import overview_table, question, race_told
from harness.results import pay_texts
from harness_plugins.committed import write_summary
from tests.report import conftest
from tests.results.in_looks import RACE, folder_in_looks


@pytest.fixture
def folder(make_cell, make_plan, tmp_path):
    """Three rewards, nothing done yet."""
    return folder_in_looks(RACE, make_cell, make_plan, load_registry(), tmp_path)


@pytest.fixture
def over(folder):
    """`dense` has beaten both others."""
    folder.train("baseline", [0.0] * 4)
    folder.train("dense", [0.9] * 4)
    folder.train("arp", [0.1] * 4)
    return folder


def told_of(folder):
    """The race in words."""
    told = race_told(folder.results)
    assert told is not None
    return told


def printed(results, *console, **given):
    """What goes to a terminal."""
    return conftest.printed(overview_table(results, "more"), *console, **given)


def test_before_the_first_look_there_is_nothing_to_tell(folder):
    """Nor to print."""
    assert race_told(folder.results) is None
    assert "BEST" not in printed(folder.results)


def test_the_best_is_named_with_what_the_test_promises(over):
    """In one line."""
    sentence = "BEST: dense. All others are worse. The test is made to err in at most 5 % of such races."
    assert told_of(over).sentence == sentence


def test_the_best_comes_first_and_the_others_say_who_beat_them(over):
    """A row for each reward, the baseline too."""
    rows = {row[0]: row[1:] for row in told_of(over).grid.rows}
    assert list(rows) == ["dense", "arp", "baseline"]
    assert rows["dense"][:3] == ("BEST", "90.0%", "4")
    assert rows["baseline"][0] == "worse than dense"


def test_the_number_stands_beside_its_ruler(over):
    """What a reward says of its own trainings decides nothing."""
    rows = {row[0]: row for row in told_of(over).grid.rows}
    assert rows["baseline"][4:] == ("", "")
    pay = next(it.number.pay for it in over.results.combinations if it.proposed == "arp")
    assert rows["arp"][4:] == pay_texts(pay)[1:3]


def test_rewards_that_are_as_good_are_named_together(make_cell, make_plan, tmp_path):
    """Within five points of the best: 28 trainings that end alike say so."""
    folder = folder_in_looks(replace(RACE, looks=(28,)), make_cell, make_plan, load_registry(), tmp_path)
    folder.train("baseline", [0.0] * 28)
    folder.train("dense", [0.5] * 28)
    folder.train("arp", [0.5] * 28)
    told = told_of(folder)
    assert told.sentence.startswith("WITHIN 5 POINTS OF THE BEST: ")
    assert told.sentence.endswith("baseline is worse.")


def test_a_race_that_goes_on_says_how_it_stands(folder):
    """And how many trainings may be left."""
    for reward in ("baseline", "dense", "arp"):
        folder.train(reward, [0.2, 0.8])
    assert "After 2 seeds, these can still be the best" in told_of(folder).sentence
    assert told_of(folder).sentence.endswith("At most 6 trainings are left.")


def test_looks_that_ran_out_leave_the_question_open(folder):
    """No word of better or worse."""
    for reward in ("baseline", "dense", "arp"):
        folder.train(reward, [0.2, 0.8, 0.5, 0.4])
    assert told_of(folder).sentence.startswith("CANNOT TELL after 4 seeds which is best")


def test_where_no_training_left_a_number_nothing_is_best(folder):
    """All of them left."""
    for cells in folder.cells.values():
        for cell in cells:
            folder.store.cell_folder(cell).mkdir(exist_ok=True)
            folder.store.record(cell, "failed", "it broke")
    assert told_of(folder).sentence == "CANNOT TELL: no reward left a number in its trainings."


@pytest.mark.parametrize("width", [60, 80, 120])
def test_the_table_fits(over, width):
    """Into a terminal of this width."""
    text = printed(over.results, width)
    assert max(map(len, text.splitlines())) <= width
    assert "BEST: dense" in text


def test_a_summary_tells_of_the_race(over, tmp_path):
    """With its table and its figure: the name of each reward, and after how many seeds it left."""
    write_summary(over.results, tmp_path / "told")
    page = (tmp_path / "told" / "summary.md").read_text()
    assert "## The race for the best reward\n\n**BEST: dense" in page
    assert "| dense | BEST | 90.0% | 4 |" in page
    figure = (tmp_path / "told" / "figures" / "race.svg").read_text()
    assert {*re.findall(r">(dense|\w+, left at \d+)<", figure)} == {"dense", "arp, left at 4", "baseline, left at 4"}


def test_the_question_is_which_is_best(over):
    """And not whether each is better than the baseline."""
    assert question(over.results) == "Which reward makes the robot behave best: baseline, dense or arp?"


def test_without_a_race_the_question_is_about_each(make_cell, make_plan, tmp_path):
    """As ever."""
    folder = folder_in_looks(Terms((2, 4)), make_cell, make_plan, load_registry(), tmp_path)
    assert race_told(folder.results) is None
    assert question(folder.results).startswith("Do the rewards dense and arp make")
