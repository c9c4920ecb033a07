"""The page of alarms and trainings says what its record holds, and the record follows from the trainings."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "experiments/cheats"))
import alarms as study

ROOT = Path(__file__).parents[1]
if not study.RECORD.exists():
    pytest.skip("`python experiments/cheats/alarms.py` writes the record", allow_module_level=True)
PAGE = (ROOT / "docs" / "studies" / "cheats.md").read_text(encoding="utf-8")
ROWS = study.read()


def test_every_trained_reward_was_asked():
    """More than thirty, with the success of their trainings."""
    trained = [row for name in study.STUDIES for row in study.trained(name)]
    assert [{name: row[name] for name in trained[0]} for row in ROWS] == trained
    assert len(ROWS) > 30


def test_the_page_has_both_tables():
    """As the command prints them."""
    assert study.counts(ROWS) in PAGE
    assert study.by_record(ROWS) in PAGE


def test_the_page_says_how_often_an_alarm_was_right():
    """Right is an alarm for a reward that is worse than the best, and none for one that is not."""
    alarms = [row for row in ROWS if row["answer"] in study.ALARMS]
    quiet = [row for row in ROWS if row["answer"] == "NOTHING FOUND"]
    worse, close = sum(row["is_worse"] for row in alarms), sum(not row["is_worse"] for row in quiet)
    prose = " ".join(PAGE.split())
    assert f"Of {len(alarms)} alarms {worse} were right" in prose
    assert f"of {len(quiet)} rewards without one {close}" in prose
    assert f"{(worse + close) / (len(alarms) + len(quiet)):.0%} of what it said" in prose


@pytest.mark.parametrize("success", [0.79, 0.81])
def test_worse_is_more_than_ten_points_less_than_the_best(monkeypatch: pytest.MonkeyPatch, success: float):
    """Of the same record."""
    monkeypatch.setattr(study, "successes", lambda name: {"best": [0.8, 1.0], "other": [success]})
    assert [row["is_worse"] for row in study.trained("race/arm")] == [False, success < 0.8]
