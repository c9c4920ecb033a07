"""``harness choose``: the best of several rewards."""

import json
from pathlib import Path

import pytest

from tests.registry.test_given import REWARD

RAISES = REWARD.replace("return ", "raise ValueError('no idea')\n        return ", 1)
RAISES_LATER = RAISES.replace("raise ", "if len(begin_distance) != 2:\n            raise ", 1)


@pytest.fixture
def candidates(tmp_path: Path) -> Path:
    """Two rewards, each in a file."""
    folder = tmp_path / "candidates"
    folder.mkdir()
    (folder / "one.py").write_text(REWARD)
    (folder / "other.py").write_text(REWARD.replace("self.scale *", "2 * self.scale *"))
    return folder


def choose(harness, quick, *more: object):
    """Among the files of the folder."""
    return harness("choose", "--plugin", "candidates/*.py", *quick, "--looks", "2,4", *more)


def race_of(folder: Path, harness) -> dict[str, object]:
    """What the report says of the race."""
    told: dict[str, object] = json.loads(harness("report", folder, "--json").out)["looks"]["race"]
    return told


def test_every_file_is_a_candidate_named_by_its_file(harness, quick, candidates: Path, tmp_path):
    """And the baseline takes part."""
    answer = choose(harness, quick, "--out", "here")
    assert answer.status == 0
    told = race_of(tmp_path / "here", harness)
    assert {*told["living"], *told["beaten"]} == {"baseline", "one", "other"}
    for name in ("baseline", "one", "other"):
        assert name in answer.out


def test_rewards_that_look_alike_use_all_looks(harness, quick, candidates: Path, tmp_path):
    """An arm that acts at random fails as often under each. Of four trainings that fail, a fifth one may not."""
    choose(harness, quick, "--out", "here")
    told = race_of(tmp_path / "here", harness)
    assert (told["is_close"], told["is_over"], told["looks"]) == (False, True, 2)
    assert len(list((tmp_path / "here" / "cells").iterdir())) == 12


def test_a_broken_file_is_a_row_with_the_reason(harness, quick, candidates: Path):
    """And no end."""
    (candidates / "broken.py").write_text("def (:")
    answer = choose(harness, quick, "--out", "here")
    assert answer.status == 0
    assert "broken" in answer.out
    assert "invalid syntax" in " ".join(answer.out.split())


def test_a_candidate_that_raises_at_once_is_left_out(harness, quick, candidates: Path, tmp_path):
    """Before anything is trained, with the reason; the race of the others goes on."""
    (candidates / "raises.py").write_text(RAISES)
    answer = choose(harness, quick, "--out", "here")
    assert answer.status == 0
    assert "Left out, tried in an episode of random actions: reward 'raises' fails" in answer.err
    assert "ValueError: no idea (raises.py, line" in answer.err
    assert "raises" not in race_of(tmp_path / "here", harness)["living"]


def test_a_candidate_that_raises_leaves_the_race(harness, quick, candidates: Path, tmp_path):
    """If the trial before did not see it, its trainings fail; nobody beat it."""
    (candidates / "raises.py").write_text(RAISES_LATER)
    answer = choose(harness, quick, "--out", "here")
    assert answer.status == 1
    assert race_of(tmp_path / "here", harness)["beaten"]["raises"]["by"] == ""


def test_rewards_can_be_named(harness, quick, tmp_path):
    """Without files."""
    answer = harness("choose", "--reward", "dense,arp", *quick, "--looks", "2,4", "--out", "here")
    assert answer.status == 0
    assert set(race_of(tmp_path / "here", harness)["living"]) == {"baseline", "dense", "arp"}


def test_the_same_command_goes_on(harness, quick, candidates: Path, tmp_path):
    """After a budget has ended it."""
    choose(harness, quick, "--out", "here", "--budget", "0.001s")
    assert len(list((tmp_path / "here" / "cells").iterdir())) == 1
    assert "No look is complete yet" in choose(harness, quick, "--out", "here", "--budget", "0.001s").out
    assert choose(harness, quick, "--out", "here").status == 0
    assert race_of(tmp_path / "here", harness)["is_over"]


def test_as_json_it_is_the_report(harness, quick, candidates: Path):
    """One document, and nothing else."""
    told = json.loads(choose(harness, quick, "--out", "here", "--json").out)
    assert told["looks"]["race"]["is_over"]


def test_the_page_shows_the_race(harness, quick, candidates: Path, tmp_path):
    """Who left when."""
    choose(harness, quick, "--out", "here")
    page = (tmp_path / "here" / "report.html").read_text()
    assert "a race for the best reward" in page
    assert "cannot tell after 4 seeds which is best" in page.lower()


def test_scripted_movements_come_first(harness, quick, candidates: Path):
    """What pays for standing still is named before anything is trained."""
    answer = choose(harness, quick, "--out", "here", "--screen", "--dry-run")
    assert answer.status == 0
    assert "What the rewards pay for, before anything is trained:" in answer.err
    assert "one: " in answer.err


def test_functions_of_steps_are_screened_by_term(harness, quick, tmp_path):
    """With their weights; a term that never pays is said."""
    (tmp_path / "gentle.py").write_text(
        "def gentle(step):\n"
        "    effort = (step.action - step.before.action) ** 2\n"
        "    return {'reach': -step.distance, 'effort': -effort.sum(-1), 'dock': 0.0 * step.distance}\n"
    )
    rewards = ["--plugin", "gentle.py", "--reward", "gentle,gentle:effort=0"]
    answer = harness("choose", *rewards, *quick, "--looks", "2,4", "--out", "here", "--screen", "--dry-run")
    assert answer.status == 0
    (plain, light) = (line for line in answer.err.splitlines() if line.startswith("  gentle"))
    assert "The term 'dock' never paid in " in plain
    assert "'effort'" not in plain
    assert "The term 'effort' never paid in " in light


@pytest.mark.parametrize(
    ("flags", "told"),
    [
        (["--sim", "ideal", "--algo", "wander"], "which rewards?"),
        (["--plugin", "nothing/*.py", "--sim", "ideal", "--algo", "wander"], "nothing/*.py"),
        (["--reward", "nothing", "--sim", "ideal", "--algo", "wander"], "nothing"),
        (["--reward", "dense", "--sim", "ideal", "--algo", "wander", "--looks", "4,2"], "have to increase"),
    ],
)
def test_what_cannot_be_chosen_among_says_why(harness, tmp_path, flags: list[str], told: str):
    """In one line, with status 2; nothing is written."""
    answer = harness("choose", *flags, "--out", "here")
    assert (answer.status, told in " ".join(answer.err.split())) == (2, True)
    assert not (tmp_path / "here").exists()


def test_candidates_of_one_name_are_refused(harness, quick, candidates: Path, tmp_path):
    """Each is a row, so each needs a name of its own."""
    (tmp_path / "more").mkdir()
    (tmp_path / "more" / "one.py").write_text(REWARD)
    answer = harness(
        "choose", "--plugin", "candidates/*.py", "--plugin", "more/one.py", *quick, "--looks", "2,4", "--out", "here"
    )
    assert answer.status == 2
    assert "one" in answer.err
    assert not (tmp_path / "here").exists()
