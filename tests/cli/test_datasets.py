"""Data sets as commands take them."""

import pyarrow.parquet as pq
import pytest

from tests.record.dataset.written import episode, write_lerobot, write_minari

PLACES = "--places end_effector=0:3,target=3:6"


@pytest.fixture(autouse=True)
def sets(tmp_path):
    """The data sets ``m`` and ``l``, and the file of a reward."""
    episodes = [episode(6, number, number % 2 == 1) for number in range(12)]
    write_minari(tmp_path / "m", episodes)
    write_lerobot(tmp_path / "l", episodes)
    (tmp_path / "near.py").write_text(
        "def near(observation, action, next_observation, info):\n    return -abs(float(next_observation[0]))\n"
    )


def rewards_of(answer):
    """Those that are told of."""
    return [it["reward"] for it in answer.json["rewards"]]


@pytest.mark.parametrize("dataset", ["minari:m", "lerobot:l"])
def test_audit_tells_an_answer_for_each_reward(harness, dataset):
    """Recorded, a function, and an arm's."""
    answer = harness(f"audit {dataset} --plugin near.py --reward recorded,near,arp {PLACES}")
    assert answer.status == 0
    assert answer.out.count("CANNOT TELL") + answer.out.count("RANKS ") >= 3


def test_audit_without_names_takes_what_is_there(harness):
    """The recorded reward, and the functions of the file."""
    assert rewards_of(harness("audit minari:m --plugin near.py --json")) == ["recorded", "near"]


def test_audit_writes_a_page(harness, tmp_path):
    """With the flag alone."""
    answer = harness("audit minari:m --html page.html")
    assert (answer.status, answer.err) == (0, "Page: page.html\n")
    assert "pair-0-0" in (tmp_path / "page.html").read_text()


@pytest.mark.parametrize(
    ("flags", "told"),
    [
        ("--labels labels.csv", "the file labels.csv"),
        ("--success-above 0", "a recorded return above 0"),
        ("--success 'success>0.5'", "success>0.5"),
    ],
)
def test_success_is_told_by_what_a_user_names(harness, tmp_path, flags, told):
    """And the page says what."""
    (tmp_path / "labels.csv").write_text("episode,success\n0,1\n1,0\n")
    answer = harness(f"audit minari:m --json --html page.html {flags}")
    assert (answer.status, answer.json["success_told_by"]) == (0, told)
    page = (tmp_path / "page.html").read_text().replace("&gt;", ">")
    assert f"told by {told}" in page
    assert all(line in page for line in answer.json["notes"])


def test_report_shows_the_recorded_reward(harness):
    """And takes no others."""
    assert rewards_of(harness("report lerobot:l --json")) == ["recorded"]


@pytest.mark.parametrize(("dataset", "steps"), [("minari:m", 72), ("lerobot:l", 60)])
def test_score_writes_what_each_step_is_paid(harness, tmp_path, dataset, steps):
    """Beside the data set, which stays as it is; a step after which nothing was seen has a row, and no pay."""
    before = sorted(tmp_path.rglob("*"))
    assert harness(f"score {dataset} --plugin near.py --reward near,arp {PLACES}").status == 0
    written = tmp_path / f"{dataset[-1]}.scores.parquet"
    assert sorted(tmp_path.rglob("*")) == sorted([*before, written])
    table = pq.read_table(written)
    assert (table.column_names, table.num_rows) == (["episode", "step", "near", "arp"], 72)
    assert [table[name].null_count for name in ("near", "arp")] == [72 - steps] * 2


def test_a_reward_that_fails_is_told_and_the_others_go_on(harness, tmp_path):
    """Status 1."""
    (tmp_path / "bad.py").write_text("def bad(observation, action, next_observation, info):\n    return 1 / 0\n")
    answer = harness("audit minari:m --plugin bad.py --plugin near.py --json")
    assert (answer.status, rewards_of(answer)) == (1, ["recorded", "near"])
    assert "reward bad: n/a (episode 0: ZeroDivisionError" in answer.err


@pytest.mark.parametrize("folder", ["minari:m", "lerobot:l"])
@pytest.mark.parametrize("command", ["audit", "report"])
def test_a_folder_that_is_a_data_set_needs_no_format(harness, command, folder):
    """It is no training, whose first episodes would stand beside its last ones."""
    named, bare = (harness(f"{command} {it} --json") for it in (folder, folder[-1]))
    assert (bare.status, bare.json) == (0, named.json)


@pytest.mark.parametrize(("pays", "status"), [(-1.0, 1), (1.0, 0), (0.0, 3)])
def test_how_a_reward_ranks_can_be_the_status(harness, tmp_path, pays, status):
    """Against success, as it does, and as a coin would: of an audit, and of a report."""
    episodes = [episode(6, number, number % 2 == 1) for number in range(12)]
    for number, one in enumerate(episodes):
        one["rewards"][:] = pays * (number % 2) + 0.01 * number * (pays != 0.0)
    write_minari(tmp_path / "paid", episodes)
    for command in ("audit", "report"):
        answer = harness(f"{command} minari:paid --fail-on against")
        assert answer.status == status
        assert answer.err.startswith("--fail-on against: recorded: ")
