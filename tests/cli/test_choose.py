"""``harness choose``: which of several rewards goes furthest, and whether it helps."""

import pytest

from tests.registry.test_given import REWARD

RAISES = REWARD.replace("return ", "raise ValueError('no idea')\n        return ", 1)
RAISES_LATER = RAISES.replace("raise ", "if len(begin_distance) != 2:\n            raise ", 1)


FILES = "choose --plugin 'candidates/*.py' --out mine"
LINE = f"{FILES} --budget 12"


@pytest.fixture
def candidates(tmp_path):
    """Two rewards, each in a file."""
    folder = tmp_path / "candidates"
    folder.mkdir()
    (folder / "one.py").write_text(REWARD)
    (folder / "other.py").write_text(REWARD.replace("self.scale *", "2 * self.scale *"))
    return folder


@pytest.fixture
def chosen(trained, quick, candidates):
    """What is said of a choice between them."""
    return trained(LINE, *quick)


@pytest.fixture
def troubled(trained, quick, candidates):
    """The same beside a file that is broken, and rewards that raise at once, and later."""
    for name, source in {"broken": "def (:", "raises": RAISES, "later": RAISES_LATER}.items():
        (candidates / f"{name}.py").write_text(source)
    return trained(FILES, *quick, "--budget", 14, "--jobs", 1)


def told_of(harness, folder="mine"):
    """What the report says of the choice."""
    return harness(f"report {folder} --json").json["choosing"]


def cells_of(harness):
    """The reward and the status of each cell."""
    return [(it["reward"], it["status"]) for it in harness("report mine --json").json["cells"]]


def test_every_file_is_a_candidate_named_by_its_file(harness, chosen):
    """The baseline is none: it is trained with the new seeds alone."""
    told = told_of(harness)
    assert chosen.status == 0
    assert told["rungs"] == [{"candidates": 2, "seeds": 2}]
    assert {*told["means"][0]} == {"one", "other"}
    ended = cells_of(harness)
    assert ended.count(("baseline", "done")) == told["fresh"] == 4
    assert sum(status == "done" for _, status in ended) == 12
    assert {status for _, status in ended} == {"done", "not needed"}


def test_the_one_that_went_furthest_is_compared_on_new_trainings_alone(harness, chosen):
    """Of arms that act at random the first one is as good as any."""
    (told,) = harness("report mine --json").json["combinations"]
    assert (told["proposed"], [len(of) for of in told["trained"].values()]) == (told_of(harness)["furthest"], [4, 4])
    said = " ".join(chosen.out.split())
    assert "one went furthest of 2 (4 trainings). On 4 new trainings of each, " in said
    assert "best" not in said


def test_the_page_shows_how_far_each_went(chosen, tmp_path):
    """And the question is about all candidates."""
    page = (tmp_path / "mine" / "report.html").read_text()
    assert "How far the candidates went" in page
    assert "Which of one and other makes the robot behave better than baseline?" in page


def test_a_broken_file_is_a_row_with_the_reason(troubled):
    """And no end."""
    assert "broken" in troubled.out
    assert "invalid syntax" in " ".join(troubled.out.split())


def test_a_candidate_that_raises_at_once_is_left_out(harness, troubled):
    """Before anything is trained, with the reason; the choice between the others goes on."""
    assert "Left out, tried in an episode of random actions: reward 'raises' fails" in troubled.err
    assert "ValueError: no idea (raises.py, line" in troubled.err
    assert "raises" not in told_of(harness)["means"][0]


def test_a_candidate_that_raises_goes_no_further(harness, troubled):
    """If the trial before did not see it, its training fails, and counts as the worst that there is."""
    assert troubled.status == 1
    means = told_of(harness)["means"][0]
    assert means["later"] == 0.0
    assert told_of(harness)["furthest"] in {"one", "other"}


def test_rewards_can_be_named(harness, quick):
    """Without files; before anything is trained the schedule is told."""
    out = harness("choose --reward dense,arp --budget 20 --out mine --dry-run", *quick).out
    assert "At most 20 cells: 20 to do\nCandidates: dense, arp\n" in out
    assert "In each place: 2 with 5 trainings each. Then 5 new ones of the one that is left" in out


@pytest.mark.parametrize(
    ("flags", "told"),
    [
        ("--reward dense,arp --budget 9", "10 trainings are the fewest that can tell anything of 2 candidates; 28 are"),
        (
            "--reward dense,arp --budget soon",
            "--budget soon: give a number of trainings, such as 60, or a time",
        ),
        ("--reward dense", "one candidate leaves nothing to choose"),
        ("", "which rewards? Name them"),
    ],
)
def test_what_cannot_be_chosen_says_why(harness, quick, tmp_path, flags, told):
    """Before anything is written."""
    answer = harness(f"choose {flags} --out mine", *quick)
    assert answer.status == 2
    assert told in answer.err
    assert not (tmp_path / "mine").exists()


def test_the_same_command_goes_on(harness, chosen, quick, tmp_path):
    """After it was stopped: what is there is not trained again, and the answer is the same."""
    before, cells = told_of(harness), sorted((tmp_path / "mine" / "cells").iterdir())
    for cell in cells[::2]:
        cell.rename(tmp_path / cell.name)
    assert "at most" in harness("status mine").out
    assert harness(LINE, *quick).status == 0
    assert told_of(harness) == before
    assert sorted((tmp_path / "mine" / "cells").iterdir()) == cells


def test_another_budget_is_another_experiment(harness, chosen, quick):
    """Of trainings: whoever looked and trains on gives luck a second chance."""
    answer = harness(f"{FILES} --budget 16", *quick)
    assert answer.status == 2
    assert "its budget" in answer.err


def test_a_time_is_turned_into_trainings(harness, quick, candidates):
    """By the first one of each. Too short a time ends there and says what is enough, and a longer one goes on."""
    line = (FILES, *quick, "--jobs", 1)
    told = " ".join(harness(*line, "--budget", "0.001s").out.split())
    assert "0 trainings, and 10 are the fewest that can tell anything. The same command with --budget 1min" in told
    assert [status for _, status in cells_of(harness)].count("done") == 2
    assert harness(*line, "--budget", "10h").status == 0
    assert told_of(harness)["budget"] == 4 * 28
    answer = harness(*line, "--budget", "11h")
    assert answer.status == 2
    assert "its budget" in answer.err


def test_as_json_it_is_the_report(harness, quick, chosen):
    """One document, and nothing else."""
    assert harness(LINE, *quick, "--json").json["choosing"]["is_over"]


def test_functions_of_steps_are_screened_by_term(harness, quick, tmp_path):
    """Before anything is trained, with their weights; a term that never pays is said."""
    (tmp_path / "gentle.py").write_text(
        "def gentle(step):\n"
        "    effort = (step.action - step.before.action) ** 2\n"
        "    return {'reach': -step.distance, 'effort': -effort.sum(-1), 'dock': 0.0 * step.distance}\n"
    )
    rewards = ["--plugin", "gentle.py", "--reward", "gentle,gentle:effort=0"]
    answer = harness("choose", *rewards, *quick, "--budget", "12", "--out", "here", "--screen", "--dry-run")
    assert answer.status == 0
    assert "What the rewards pay for, before anything is trained:" in answer.err
    (plain, light) = (line for line in answer.err.splitlines() if line.startswith("  gentle"))
    assert "The term 'dock' never paid in " in plain
    assert "'effort'" not in plain
    assert "The term 'effort' never paid in " in light


def test_candidates_of_one_name_are_refused(harness, quick, candidates, tmp_path):
    """Each is a row, so each needs a name of its own."""
    (tmp_path / "more").mkdir()
    (tmp_path / "more" / "one.py").write_text(REWARD)
    answer = harness("choose --plugin 'candidates/*.py' --plugin more/one.py --out here", *quick)
    assert answer.status == 2
    assert "one" in answer.err
    assert not (tmp_path / "here").exists()
