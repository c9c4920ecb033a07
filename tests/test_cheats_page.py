"""The page of alarms and trainings says what its record holds, and the record follows from the trainings."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "experiments/cheats"))
import alarms as study

from tests.project import page_of

if not study.RECORD.exists():
    pytest.skip("`python experiments/cheats/alarms.py` writes the record", allow_module_level=True)
PAGE = page_of("studies/cheats")
ROWS = study.read()


def test_every_trained_reward_was_asked():
    """Thirty-three, with the success of their trainings."""
    trained = [row for name in study.STUDIES for row in study.trained(name)]
    assert [{name: row[name] for name in trained[0]} for row in ROWS] == trained
    assert len(ROWS) == 33


def test_the_page_has_the_table():
    """As the command prints it."""
    assert study.counts(ROWS) in PAGE


def test_the_page_says_how_often_an_answer_was_right():
    """In the words of the command."""
    assert study.in_words(ROWS) in " ".join(PAGE.split())


def test_right_is_an_alarm_for_a_worse_reward_and_none_for_a_close_one():
    """Two of three: the second alarm is for the best. What could not be told does not count."""
    said = [("PAYS FOR FAILING", True), ("PAYS FOR LOITERING", False), ("NOTHING FOUND", False)]
    rows = [{"answer": answer, "is_worse": is_worse} for answer, is_worse in (*said, ("CANNOT TELL", True))]
    assert "Of 2 alarms 1 were right. Of 1 rewards" in study.in_words(rows)
    assert "67%" in study.in_words(rows)


@pytest.mark.parametrize("success", [0.79, 0.81])
def test_worse_is_more_than_ten_points_less_than_the_best(monkeypatch, success):
    """Of the same record."""
    monkeypatch.setattr(study, "successes", lambda name: {"best": [0.8, 1.0], "other": [success]})
    assert [row["is_worse"] for row in study.trained("race/arm")] == [False, success < 0.8]
