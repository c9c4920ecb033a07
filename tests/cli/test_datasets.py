"""Data sets as commands take them."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from harness.cli import main
from tests.record.dataset.written import episode, write_lerobot, write_minari

PLACES = ("--places", "end_effector=0:3,target=3:6")


@pytest.fixture
def call(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path):
    """Run ``harness`` in a folder with the data sets ``m`` and ``l``: status, output and errors."""
    monkeypatch.delenv("HARNESS_PLUGINS", raising=False)
    monkeypatch.chdir(tmp_path)
    episodes = [episode(6, number, number % 2 == 1) for number in range(12)]
    write_minari(tmp_path / "m", episodes)
    write_lerobot(tmp_path / "l", episodes)
    (tmp_path / "near.py").write_text(
        "def near(observation, action, next_observation, info):\n    return -abs(float(next_observation[0]))\n"
    )

    def run(*arguments: str) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as stopped:
            main(list(arguments))
        told = capsys.readouterr()
        return stopped.value.code or 0, told.out, told.err

    return run


@pytest.mark.parametrize("dataset", ["minari:m", "lerobot:l"])
def test_audit_tells_an_answer_for_each_reward(call, dataset: str):
    """Recorded, a function, and an arm's."""
    status, out, _ = call("audit", dataset, "--plugin", "near.py", "--reward", "recorded,near,arp", *PLACES)
    assert status == 0
    assert out.count("CANNOT TELL") + out.count("RANKS ") >= 3


def test_audit_without_names_takes_what_is_there(call):
    """The recorded reward, and the functions of the file."""
    _, out, _ = call("audit", "minari:m", "--plugin", "near.py", "--json")
    assert [it["reward"] for it in json.loads(out)["rewards"]] == ["recorded", "near"]


def test_audit_writes_a_page(call, tmp_path: Path):
    """With the flag alone."""
    status, _, err = call("audit", "minari:m", "--html", "page.html")
    assert (status, err) == (0, "Page: page.html\n")
    assert "pair-0-0" in (tmp_path / "page.html").read_text()


@pytest.mark.parametrize("flags", [("--labels", "labels.csv"), ("--success-above", "0"), ("--success", "success>0.5")])
def test_success_is_told_by_what_a_user_names(call, tmp_path: Path, flags: tuple[str, str]):
    """And the page says what."""
    (tmp_path / "labels.csv").write_text("episode,success\n0,1\n1,0\n")
    status, out, _ = call("audit", "minari:m", "--json", "--html", "page.html", *flags)
    told = {"--labels": "the file labels.csv", "--success-above": "a recorded return above 0"}
    assert status == 0
    assert json.loads(out)["success_told_by"] == told.get(flags[0], flags[1])
    page = (tmp_path / "page.html").read_text().replace("&gt;", ">")
    assert f"told by {json.loads(out)['success_told_by']}" in page
    assert all(line in page for line in json.loads(out)["notes"])


def test_report_shows_the_recorded_reward(call):
    """And takes no others."""
    status, out, _ = call("report", "lerobot:l", "--json")
    assert status == 0
    assert [it["reward"] for it in json.loads(out)["rewards"]] == ["recorded"]


@pytest.mark.parametrize(("dataset", "steps"), [("minari:m", 72), ("lerobot:l", 60)])
def test_score_writes_what_each_step_is_paid(call, tmp_path: Path, dataset: str, steps: int):
    """Beside the data set, which stays as it is; a step after which nothing was seen has a row, and no pay."""
    before = sorted(tmp_path.rglob("*"))
    status, _, _ = call("score", dataset, "--plugin", "near.py", "--reward", "near,arp", *PLACES)
    assert status == 0
    name = f"{dataset[-1]}.scores.parquet"
    assert sorted(tmp_path.rglob("*")) == sorted([*before, tmp_path / name])
    table = pq.read_table(tmp_path / name)
    assert table.column_names == ["episode", "step", "near", "arp"]
    assert table.num_rows == 72
    assert [table[name].null_count for name in ("near", "arp")] == [72 - steps] * 2


def test_a_reward_that_fails_is_told_and_the_others_go_on(call, tmp_path: Path):
    """Status 1."""
    (tmp_path / "bad.py").write_text("def bad(observation, action, next_observation, info):\n    return 1 / 0\n")
    status, out, err = call("audit", "minari:m", "--plugin", "bad.py", "--plugin", "near.py", "--json")
    assert status == 1
    assert [it["reward"] for it in json.loads(out)["rewards"]] == ["recorded", "near"]
    assert "reward bad: n/a (episode 0: ZeroDivisionError" in err


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("audit", "minari:none"), "No Minari data set at 'none'"),
        (("audit", "lerobot:none"), "No LeRobot data set at 'none'"),
        (("audit", "minari:m", "--reward", "arp"), "--places end_effector=0:3,target=3:6"),
        (("audit", "minari:m", "--reward", "arp", "--places", "end_effector=0:3,target=4:7"), "beyond the 6 numbers"),
        (("audit", "minari:m", "--sim", "mujoco"), "--sim does not go with a data set"),
        (("audit", "minari:m", "--success", "won"), "it has success"),
        (("audit", "minari:m", "--success", "sucess"), "Did you mean 'success'?"),
        (("audit", "minari:m", "--success", "success>x"), "write KEY, or KEY>0.5"),
        (("audit", "minari:m", "--labels", "near.py"), "it needs episode and success"),
        (("audit", "minari:m", "--labels", "l.csv", "--success-above", "1"), "leave out one"),
        (("audit", "--reward", "arp", "--partial"), "--partial needs a data set"),
        (("audit", "--reward", "arp", "--places", "end_effector=0:3,target=3:6"), "--places needs a data set"),
        (("score", "minari:m", "--all"), "--all does not go with a data set"),
        (("score", "m.csv", *PLACES), "--places needs a data set"),
        (("score", "minari:m", "lerobot:l"), "One data set is scored at a time"),
        (("report", "minari:m", "lerobot:l"), "One data set is reported at a time"),
        (("report", "minari:m", "--pairs"), "--pairs does not go with a data set"),
        (("report", "minari:m", "--sort", "{reward}"), "--sort does not go with a data set"),
    ],
)
def test_what_cannot_be_done_is_one_line(call, arguments: tuple[str, ...], told: str):
    """Status 2."""
    status, out, err = call(*arguments)
    assert (status, out) == (2, "")
    assert told in err
    assert "Traceback" not in err


@pytest.mark.parametrize("folder", ["m", "l"])
@pytest.mark.parametrize("command", ["audit", "report"])
def test_a_folder_that_is_a_data_set_needs_no_format(call, command: str, folder: str):
    """It is no training, whose first episodes would stand beside its last ones."""
    _, typed, _ = call(command, f"{'minari' if folder == 'm' else 'lerobot'}:{folder}", "--json")
    status, out, _ = call(command, folder, "--json")
    assert (status, json.loads(out)) == (0, json.loads(typed))


@pytest.mark.parametrize(("pays", "status"), [(-1.0, 1), (1.0, 0), (0.0, 3)])
def test_how_a_reward_ranks_can_be_the_status(call, tmp_path: Path, pays: float, status: int):
    """Against success, as it does, and as a coin would: of an audit, and of a report."""
    episodes = [episode(6, number, number % 2 == 1) for number in range(12)]
    for number, one in enumerate(episodes):
        one["rewards"][:] = pays * (number % 2) + 0.01 * number * (pays != 0.0)
    write_minari(tmp_path / "paid", episodes)
    for command in ("audit", "report"):
        found, _, err = call(command, "minari:paid", "--fail-on", "against")
        assert found == status
        assert err.startswith("--fail-on against: recorded: ")


def test_what_no_data_set_says_is_refused(call):
    """Before it is opened."""
    status, _, err = call("audit", "minari:gone", "--fail-on", "hurts")
    assert (status, err.count("\n")) == (2, 1)
    assert "No answer 'hurts'. There is: against, cannot-tell, failing, loitering." in err
