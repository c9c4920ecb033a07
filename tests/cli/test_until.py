"""``harness run --until decided``: trains in looks, and stops where the answer stands."""

import json

import pytest

LINE = "run --reward dense --until decided --looks 2,4,6 --margin 0.96 --out mine"


@pytest.fixture
def folder(trained, quick, tmp_path):
    """An arm that acts at random succeeds as often under either reward: below so wide a margin from four seeds on."""
    assert trained(LINE, *quick).status == 0
    return tmp_path / "mine"


def done(folder):
    """How many cells are done."""
    return sum(json.loads(it.read_text())["status"] == "done" for it in folder.glob("cells/*/manifest.json"))


def test_looks_margin_and_questions_stand_in_the_plan(folder):
    """Written before the first training."""
    terms = json.loads((folder / "plan.json").read_text())["terms"]
    assert (terms["looks"], terms["asked"], terms["margin"]) == ([2, 4, 6], 1, 0.96)


def test_the_report_tells_of_the_looks(harness, folder):
    """In the table, as JSON and on the page."""
    assert "Looks at 2, 4, 6 seeds (trained until decided" in " ".join(harness("report", folder).out.split())
    told = harness("report", folder, "--json").json
    assert told["looks"]["open"] == []
    assert [it["status"] for it in told["cells"]].count("not needed") == 4
    assert told["terms"]["looks"] == [2, 4, 6]
    page = (folder / "report.html").read_text()
    assert "Looks at 2, 4, 6 seeds" in page
    assert "12 cells: 8 done, 4 not needed" in page


def test_status_tells_how_it_stands(harness, folder):
    """In words and as JSON."""
    assert "12 cells: 8 done, 4 not needed\n1 of 1 decided\n" in harness("status", folder).out
    assert harness("status", folder, "--json").json["looks"]["most_trainings_left"] == 0


def test_a_run_that_was_cut_short_goes_on(harness, quick, tmp_path):
    """By the same command; what was done stays."""
    harness(LINE, *quick, "--limit", 3)
    assert done(tmp_path / "mine") == 3
    assert "0 of 1 decided, at most 9 trainings left" in harness("status mine").out
    kept = {it: it.read_bytes() for it in (tmp_path / "mine").glob("cells/*/manifest.json")}
    harness(LINE, *quick)
    assert done(tmp_path / "mine") == 8
    assert all(it.read_bytes() == before for it, before in kept.items())


def test_the_experiment_file_repeats_it(harness, folder, tmp_path):
    """With its looks, and no seeds."""
    assert "seeds" not in (folder / "experiment.toml").read_text()
    assert harness("run", folder / "experiment.toml", "--executor", "here", "--out", "again").status == 0
    assert done(tmp_path / "again") == 8


def test_an_experiment_that_named_seeds_can_be_asked_so(harness, quick, tmp_path):
    """The seeds of its file make room for the looks."""
    harness("run --reward dense --seeds 1 --out before", *quick)
    assert harness("run before/experiment.toml --until decided --looks 2,4 --executor here --out mine").status == 0
    assert done(tmp_path / "mine") == 8


def test_a_budget_ends_a_run_between_cells(harness, quick, tmp_path):
    """At least one cell is done."""
    assert harness(LINE, *quick, "--budget", "0.001s").status == 0
    assert done(tmp_path / "mine") == 1


def test_dry_run_says_how_many_trainings_it_may_take(harness, quick, tmp_path):
    """At the first look, and in all of them; no list of seeds that may never be trained."""
    answer = harness(LINE, *quick, "--dry-run")
    assert answer.status == 0
    assert "At most 12 cells: 12 to do\n" in answer.out
    assert "Looks: at 2, 4, 6 seeds of each. The first takes 4 cells. The run ends with the answer\n" in answer.out
    assert "dense: 6 seeds\n" in answer.out
    assert not (tmp_path / "mine").exists()


def test_seeds_that_no_look_asked_for_are_told(harness, quick):
    """A folder that grew by hand: its report says what that costs."""
    harness("run --reward dense --seeds 1 --out here", *quick)
    harness("run --reward dense --seeds 2 --out here", *quick)
    told = " ".join(harness("report here").out.split())
    assert "Seeds were added after 1 seed had been trained" in told
    assert "So intervals that decide have 98 %." in told
