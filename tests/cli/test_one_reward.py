"""``harness run``, ``report`` and ``eta`` of one reward alone: what it paid for."""

import json

import pytest

from tests.results.gentle import SOURCE

ALONE = ("run", "--task", "gymnasium:id=CartPole-v1", "--algo", "random", "--steps", "40", "--seeds", "2")
SHORT = (*ALONE, "--evaluation-episodes", "1", "--executor", "here", "--out", "mine")
OWN = "def other(observation, action, next_observation, info):\n    return 0.5\n"
JUDGING = ("better", "worse", "HELPS", "HURTS", "CANNOT TELL", " eta ")


@pytest.fixture
def gentle(harness, quick, tmp_path):
    """Flags of a run of one reward with terms."""
    (tmp_path / "gentle.py").write_text(SOURCE)
    return ("run", *quick, "--reward", "gentle", "--baseline", "none", "--plugin", "gentle.py", "--seeds", "2")


def test_one_reward_of_an_arm_is_a_question(harness, gentle, tmp_path):
    """The sentence first says what was asked; no word judges."""
    answer = harness(*gentle, "--out", "mine")
    assert answer.status == 0
    assert answer.out.startswith("What did gentle pay for? 2 trainings, 12 steps each.\n")
    assert "gentle: `dock` never paid in 24 steps." in answer.out
    assert "harness run mine/experiment.toml --reward OTHER --out mine" in " ".join(answer.out.split())
    assert not [word for word in JUDGING if word in answer.out]
    page = (tmp_path / "mine" / "report.html").read_text()
    assert "<h1>What did gentle pay for?</h1>" in page
    assert "<code>dock</code> never paid in 24 steps." in page


def test_details_have_every_measure_and_every_term(harness, gentle):
    """Of the same trainings."""
    harness(*gentle, "--out", "mine")
    answer = harness("report", "mine", "--details", "--plugin", "gentle.py")
    assert answer.status == 0
    assert answer.out.startswith("What did gentle pay for? 2 trainings, 12 steps each.\n")
    assert "What each term paid: gentle" in answer.out
    assert "closest distance [m]" in answer.out


def test_json_has_new_keys_alone(harness, gentle):
    """Beside those that there were."""
    harness(*gentle, "--out", "mine")
    data = json.loads(harness("report", "mine", "--json").out)
    assert (data["combinations"], data["alone"][0]["reward"]) == ([], "gentle")
    assert data["reward_terms"][0]["never_paid"] == ["dock"]


def test_two_rewards_need_a_baseline(harness, quick):
    """One line with what to type instead, and no folder."""
    answer = harness("run", *quick, "--reward", "arp,dense", "--baseline", "none")
    assert (answer.status, answer.out, answer.err.count("\n")) == (2, "", 1)
    assert "baseline=none trains one reward alone, and 2 are named" in answer.err


def test_the_other_reward_joins_it(harness, gentle, quick, tmp_path):
    """As the page says; then they are compared."""
    harness(*gentle, "--out", "mine")
    joined = harness("run", "mine/experiment.toml", "--reward", "arp", "--out", "mine", "--plugin", "gentle.py")
    assert joined.status == 0
    assert "What did" not in joined.out
    assert json.loads(harness("report", "mine", "--json").out)["combinations"][0]["baseline"] == "gentle"


@pytest.mark.parametrize("flags", [(), ("--reward", "own")])
def test_one_reward_of_an_environment_is_a_question(harness, flags):
    """Its own."""
    answer = harness(*SHORT, *flags)
    assert answer.status == 0
    assert answer.out.startswith("What did own pay for? 2 trainings, 40 steps each.\n")
    assert not [word for word in JUDGING if word in answer.out]


def test_it_is_foreseen(harness, tmp_path):
    """A dry run says what would be trained, and writes nothing."""
    answer = harness(*SHORT, "--dry-run")
    assert (answer.status, list(tmp_path.iterdir())) == (0, [])
    assert "2 cells" in answer.out


def test_the_same_reward_twice_is_a_null_control(harness):
    """It is compared with itself."""
    answer = harness(*SHORT, "--reward", "own,own")
    assert answer.status == 0
    assert "What did" not in answer.out


def test_what_the_folder_holds_counts(harness, tmp_path):
    """One reward alone joins another that was trained there before."""
    (tmp_path / "other.py").write_text(OWN)
    assert harness(*SHORT, "--plugin", "other.py", "--reward", "own,other").status == 0
    answer = harness(*SHORT, "--reward", "own", "--seeds", "3")
    assert answer.status == 0
    assert "What did" not in answer.out
