"""``harness run``, ``report`` and ``eta`` of one reward alone: what it paid for."""

import pytest

from tests.results.gentle import SOURCE

SHORT = (
    "run --task gymnasium:id=CartPole-v1 --algo random --steps 40 --seeds 2 --evaluation-episodes 1 "
    "--executor here --out mine"
)
OWN = "def other(observation, action, next_observation, info):\n    return 0.5\n"
JUDGING = ("better", "worse", "HELPS", "HURTS", "CANNOT TELL", " eta ")


@pytest.fixture
def gentle(trained, quick, tmp_path):
    """What a run of one reward with terms answers."""
    (tmp_path / "gentle.py").write_text(SOURCE)
    return trained("run --reward gentle --baseline none --plugin gentle.py --seeds 2 --out mine", *quick)


def test_one_reward_of_an_arm_is_a_question(gentle, tmp_path):
    """The sentence first says what was asked; no word judges."""
    answer = gentle
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
    answer = harness("report mine --details --plugin gentle.py")
    assert answer.status == 0
    assert answer.out.startswith("What did gentle pay for? 2 trainings, 12 steps each.\n")
    assert "What each term paid: gentle" in answer.out
    assert "closest distance [m]" in answer.out


def test_json_has_new_keys_alone(harness, gentle):
    """Beside those that there were."""
    data = harness("report mine --json").json
    assert (data["combinations"], data["alone"][0]["reward"]) == ([], "gentle")
    assert data["reward_terms"][0]["never_paid"] == ["dock"]


def test_the_other_reward_joins_it(harness, gentle):
    """As the page says; then they are compared."""
    joined = harness("run mine/experiment.toml --reward arp --out mine --plugin gentle.py")
    assert joined.status == 0
    assert "What did" not in joined.out
    assert harness("report mine --json").json["combinations"][0]["baseline"] == "gentle"


@pytest.mark.parametrize("flags", [(), ("--reward", "own")])
def test_one_reward_of_an_environment_is_a_question(harness, flags):
    """Its own."""
    answer = harness(SHORT, *flags)
    assert answer.status == 0
    assert answer.out.startswith("What did own pay for? 2 trainings, 40 steps each.\n")
    assert not [word for word in JUDGING if word in answer.out]


def test_it_is_foreseen(harness, tmp_path):
    """A dry run says what would be trained, and writes nothing."""
    answer = harness(SHORT, "--dry-run")
    assert (answer.status, list(tmp_path.iterdir())) == (0, [])
    assert "2 cells" in answer.out


def test_the_same_reward_twice_is_a_null_control(harness):
    """It is compared with itself."""
    answer = harness(SHORT, "--reward", "own,own")
    assert answer.status == 0
    assert "What did" not in answer.out


def test_what_the_folder_holds_counts(harness, tmp_path):
    """One reward alone joins another that was trained there before."""
    (tmp_path / "other.py").write_text(OWN)
    assert harness(SHORT, "--plugin", "other.py", "--reward", "own,other").status == 0
    answer = harness(SHORT, "--reward", "own", "--seeds", "3")
    assert answer.status == 0
    assert "What did" not in answer.out
