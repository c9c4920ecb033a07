"""``harness run --until decided``: trains in looks, and stops where the answer stands."""

import json
from pathlib import Path

import pytest

ASKED = ("--reward", "dense", "--until", "decided", "--looks", "2,4,6", "--margin", "0.7")


@pytest.fixture
def folder(harness, quick, tmp_path) -> Path:
    """An arm that acts at random succeeds as often under either reward: below so wide a margin from four seeds on."""
    assert harness("run", *quick, *ASKED, "--out", "here").status == 0
    return tmp_path / "here"


def done(folder: Path) -> int:
    """How many cells are done."""
    return sum(json.loads(it.read_text())["status"] == "done" for it in folder.glob("cells/*/manifest.json"))


def test_it_stops_where_the_answer_stands(folder: Path):
    """At the second look: four seeds of two rewards, and not six."""
    assert done(folder) == 8


def test_looks_margin_and_questions_stand_in_the_plan(folder: Path):
    """Written before the first training."""
    terms = json.loads((folder / "plan.json").read_text())["terms"]
    assert (terms["looks"], terms["asked"], terms["margin"]) == ([2, 4, 6], 1, 0.7)


def test_the_report_tells_of_the_looks(harness, folder: Path):
    """In the table, as JSON and on the page."""
    assert "Looks at 2, 4, 6 seeds (trained until decided" in " ".join(harness("report", folder).out.split())
    told = json.loads(harness("report", folder, "--json").out)
    assert told["looks"]["open"] == []
    assert [it["status"] for it in told["cells"]].count("not needed") == 4
    assert told["terms"]["looks"] == [2, 4, 6]
    page = (folder / "report.html").read_text()
    assert "Looks at 2, 4, 6 seeds" in page
    assert "12 cells: 8 done, 4 not needed" in page


def test_status_tells_how_it_stands(harness, folder: Path):
    """In words and as JSON."""
    told = harness("status", folder).out
    assert "12 cells: 8 done, 4 not needed\n1 of 1 decided\n" in told
    assert json.loads(harness("status", folder, "--json").out)["looks"]["most_trainings_left"] == 0


def test_a_run_that_was_cut_short_goes_on(harness, quick, tmp_path):
    """By the same command; what was done stays."""
    harness("run", *quick, *ASKED, "--limit", "3", "--out", "here")
    assert done(tmp_path / "here") == 3
    assert "0 of 1 decided, at most 9 trainings left" in harness("status", "here").out
    kept = {it: it.read_bytes() for it in (tmp_path / "here").glob("cells/*/manifest.json")}
    harness("run", *quick, *ASKED, "--out", "here")
    assert done(tmp_path / "here") == 8
    assert all(it.read_bytes() == before for it, before in kept.items())


def test_the_experiment_file_repeats_it(harness, folder: Path, tmp_path):
    """With its looks, and no seeds."""
    assert "seeds" not in (folder / "experiment.toml").read_text()
    assert harness("run", folder / "experiment.toml", "--executor", "here", "--out", "again").status == 0
    assert done(tmp_path / "again") == 8


def test_an_experiment_that_named_seeds_can_be_asked_so(harness, quick, tmp_path):
    """The seeds of its file make room for the looks."""
    harness("run", *quick, "--reward", "dense", "--seeds", "1", "--out", "before")
    file = "before/experiment.toml"
    answer = harness("run", file, "--until", "decided", "--looks", "2,4", "--executor", "here", "--out", "here")
    assert answer.status == 0
    assert done(tmp_path / "here") == 8


def test_a_budget_ends_a_run_between_cells(harness, quick, tmp_path):
    """At least one cell is done; the same command goes on."""
    assert harness("run", *quick, *ASKED, "--budget", "0.001s", "--out", "here").status == 0
    assert done(tmp_path / "here") == 1
    harness("run", *quick, *ASKED, "--out", "here")
    assert done(tmp_path / "here") == 8


def test_dry_run_says_how_many_trainings_it_may_take(harness, quick, tmp_path):
    """At the first look, and in all of them; no list of seeds that may never be trained."""
    answer = harness("run", *quick, *ASKED, "--out", "here", "--dry-run")
    assert answer.status == 0
    assert "At most 12 cells: 12 to do\n" in answer.out
    assert "Looks: at 2, 4, 6 seeds of each. The first takes 4 cells. The run ends with the answer\n" in answer.out
    assert "dense: 6 seeds\n" in answer.out
    assert not (tmp_path / "here").exists()


def test_bad_flags_say_what_is_allowed(harness, quick, tmp_path, subtests: pytest.Subtests):
    """In one line, with status 2; nothing is written."""
    rows = [
        (["--until", "decided", "--looks", "6,4"], "have to increase"),
        (["--until", "decided", "--looks", "a,b"], "--looks a,b: give numbers of seeds that increase"),
        (["--until", "decided", "--margin", "0"], "margin"),
        (["--until", "decided", "--seeds", "5"], "finds the number of seeds itself"),
        (["--until", "sunset"], "sunset"),
        (["--looks", "2,4"], "looks go with until"),
        (["--budget", "soon"], "--budget soon: give a time, such as 90s, 30m, 2h or 1d"),
        (["--budget", "-1h"], "--budget -1h: give a time"),
        (["--budget", "nanh"], "--budget nanh: give a time"),
    ]
    for flags, told in rows:
        with subtests.test(flags=flags, told=told):
            answer = harness("run", *quick, "--reward", "dense", *flags, "--out", "here")
            assert answer.status == 2
            assert told in " ".join(answer.err.split())
            assert not (tmp_path / "here").exists()


def test_seeds_that_no_look_asked_for_are_told(harness, quick):
    """A folder that grew by hand: its report says what that costs."""
    harness("run", *quick, "--reward", "dense", "--seeds", "1", "--out", "here")
    harness("run", *quick, "--reward", "dense", "--seeds", "2", "--out", "here")
    told = " ".join(harness("report", "here").out.split())
    assert "Seeds were added after 1 seed had been trained" in told
    assert "harness run --until decided keeps to 5 %" in told
