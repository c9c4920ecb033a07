import json

import pyarrow.parquet as pq
import pytest


@pytest.fixture
def experiment(finished):
    """A finished experiment."""
    return finished(seeds=2)


def test_the_matrix_has_every_reward_of_the_experiment(harness, experiment):
    """`--all` scores every training under every reward, and its diagonal is what was recorded."""
    matrix = json.loads(harness("score", experiment, "--all", "--json").out)["matrices"][0]
    combination = json.loads(harness("report", experiment, "--json").out)["combinations"][0]
    assert set(matrix["indices"]) == {"baseline", "arp"}
    assert matrix["indices"]["baseline"]["baseline"] == combination["baseline_index"]
    assert matrix["indices"]["arp"]["arp"] == combination["proposed_index"]


def test_scores_stand_beside_the_trace(harness, experiment, tmp_path):
    """Each cell gets scores.parquet with a column per reward and a row per recorded row; the trace stays."""
    cell = next((tmp_path / experiment / "cells").glob("[!.]*"))
    before = (cell / "trace.parquet").read_bytes()
    harness("score", experiment, "--reward", "arp:k2=2,dense")
    scores = pq.read_table(cell / "scores.parquet")
    assert scores.column_names == ["arp:k2=2", "dense"]
    assert scores.num_rows == pq.read_metadata(cell / "trace.parquet").num_rows
    assert (cell / "trace.parquet").read_bytes() == before


def test_the_paid_reward_is_reproduced_exactly(harness, experiment, tmp_path):
    """Scored by the reward that paid it, a trace gives its own column bit for bit."""
    harness("score", experiment, "--all")
    for cell in (tmp_path / experiment / "cells").glob("[!.]*"):
        reward = json.loads((cell / "manifest.json").read_text())["cell"]["reward"]["label"]
        paid = pq.read_table(cell / "trace.parquet", columns=["reward"])["reward"].to_numpy()
        assert (pq.read_table(cell / "scores.parquet")[reward].to_numpy() == paid).all()


def test_the_table_names_both_indices(harness, experiment, tmp_path):
    """Without --json there is a table of I_N and one of I_P; brackets in the folder's name are no markup."""
    (tmp_path / experiment).rename(tmp_path / "mine [report]")
    out = harness("score", "mine [report]", "--reward", "arp").out
    assert "I_N" in out
    assert "I_P" in out
    assert "mine [report]/cells\n" in out


def test_files_are_scored_beside_themselves(harness, experiment, tmp_path):
    """Recorded files are taken by pattern; --out collects the scores."""
    answer = harness("score", f"{experiment}/cells/*/trace.parquet", "--reward", "arp", "--json")
    assert answer.status == 0
    assert all((tmp_path / entry["scores"]).exists() for entry in json.loads(answer.out)["files"])


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["mine"], "No reward is named"),
        (["mine", "--reward", "arpp"], "Did you mean 'arp'?"),
        (["nowhere*.csv", "--reward", "arp"], "nowhere*.csv"),
        (["mine/cells/*/trace.parquet", "--all"], "--all takes an experiment's folder"),
        (["mine/cells/*/trace.parquet", "--reward", "arp", "--out", "one"], "Several files of one name"),
    ],
)
def test_bad_input_is_told_in_one_line(harness, experiment, arguments, told):
    """What cannot be used ends with status 2 and one line."""
    answer = harness("score", *arguments)
    assert (answer.status, answer.err.count("\n")) == (2, 1)
    assert told in answer.err


def test_nothing_is_scored_into_a_folder_with_a_link(harness, experiment, tmp_path):
    """It could lead anywhere."""
    (tmp_path / experiment / "cells" / "other").symlink_to(tmp_path)
    answer = harness("score", experiment, "--reward", "dense")
    assert (answer.status, answer.err.count("\n")) == (2, 1)
    assert "mine/cells/other' is a link; nothing is written" in answer.err
    assert not list((tmp_path / experiment).rglob("scores.parquet"))
