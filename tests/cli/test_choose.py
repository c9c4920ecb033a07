"""``harness choose``: the best of several rewards."""

import pytest

from tests.registry.test_given import REWARD

RAISES = REWARD.replace("return ", "raise ValueError('no idea')\n        return ", 1)
RAISES_LATER = RAISES.replace("raise ", "if len(begin_distance) != 2:\n            raise ", 1)


LINE = "choose --plugin 'candidates/*.py' --looks 2,4 --out mine"


@pytest.fixture
def candidates(tmp_path):
    """Two rewards, each in a file."""
    folder = tmp_path / "candidates"
    folder.mkdir()
    (folder / "one.py").write_text(REWARD)
    (folder / "other.py").write_text(REWARD.replace("self.scale *", "2 * self.scale *"))
    return folder


@pytest.fixture
def race(trained, quick, candidates):
    """What is said of a race between them."""
    return trained(LINE, *quick)


@pytest.fixture
def troubled(trained, quick, candidates):
    """The same beside a file that is broken, and rewards that raise at once, and later."""
    for name, source in {"broken": "def (:", "raises": RAISES, "later": RAISES_LATER}.items():
        (candidates / f"{name}.py").write_text(source)
    return trained(LINE, *quick, "--jobs", 1)


def race_of(harness):
    """What the report says of the race."""
    return harness("report mine --json").json["looks"]["race"]


def test_every_file_is_a_candidate_named_by_its_file(harness, race):
    """And the baseline takes part."""
    told = race_of(harness)
    assert race.status == 0
    assert {*told["living"], *told["beaten"]} == {"baseline", "one", "other"}
    assert all(name in race.out for name in ("baseline", "one", "other"))


def test_rewards_that_look_alike_use_all_looks(harness, race, tmp_path):
    """An arm that acts at random fails as often under each. Of four trainings that fail, a fifth one may not."""
    told = race_of(harness)
    assert (told["is_close"], told["is_over"], told["looks"]) == (False, True, 2)
    assert len(list((tmp_path / "mine" / "cells").iterdir())) == 12


def test_a_broken_file_is_a_row_with_the_reason(troubled):
    """And no end."""
    assert "broken" in troubled.out
    assert "invalid syntax" in " ".join(troubled.out.split())


def test_a_candidate_that_raises_at_once_is_left_out(harness, troubled):
    """Before anything is trained, with the reason; the race of the others goes on."""
    assert "Left out, tried in an episode of random actions: reward 'raises' fails" in troubled.err
    assert "ValueError: no idea (raises.py, line" in troubled.err
    assert "raises" not in race_of(harness)["living"]


def test_a_candidate_that_raises_leaves_the_race(harness, troubled):
    """If the trial before did not see it, its trainings fail; nobody beat it."""
    assert troubled.status == 1
    assert race_of(harness)["beaten"]["later"]["by"] == ""


def test_rewards_can_be_named(harness, quick):
    """Without files."""
    out = harness("choose --reward dense,arp --looks 2,4 --out mine --dry-run", *quick).out
    assert all(f"{name}: 4 seeds\n" in out for name in ("baseline", "dense", "arp"))


def test_the_same_command_goes_on(harness, quick, candidates, tmp_path):
    """After a budget has ended it."""
    line = LINE.replace("2,4", "2,3")
    short = (line, *quick, "--budget", "0.001s")
    harness(*short)
    assert len(list((tmp_path / "mine" / "cells").iterdir())) == 1
    assert "No look is complete yet" in harness(*short).out
    assert harness(line, *quick).status == 0
    assert race_of(harness)["is_over"]


def test_as_json_it_is_the_report(harness, quick, race):
    """One document, and nothing else."""
    assert harness(LINE, *quick, "--json").json["looks"]["race"]["is_over"]


def test_the_page_shows_the_race(race, tmp_path):
    """Who left when."""
    page = (tmp_path / "mine" / "report.html").read_text()
    assert "a race for the best reward" in page
    assert "cannot tell after 4 seeds which is best" in page.lower()


def test_functions_of_steps_are_screened_by_term(harness, quick, tmp_path):
    """Before anything is trained, with their weights; a term that never pays is said."""
    (tmp_path / "gentle.py").write_text(
        "def gentle(step):\n"
        "    effort = (step.action - step.before.action) ** 2\n"
        "    return {'reach': -step.distance, 'effort': -effort.sum(-1), 'dock': 0.0 * step.distance}\n"
    )
    rewards = ["--plugin", "gentle.py", "--reward", "gentle,gentle:effort=0"]
    answer = harness("choose", *rewards, *quick, "--looks", "2,4", "--out", "here", "--screen", "--dry-run")
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
    answer = harness("choose --plugin 'candidates/*.py' --plugin more/one.py --looks 2,4 --out here", *quick)
    assert answer.status == 2
    assert "one" in answer.err
    assert not (tmp_path / "here").exists()
