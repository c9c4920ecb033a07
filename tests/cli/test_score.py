import json

import pyarrow.parquet as pq
import pytest


@pytest.fixture
def experiment(finished):
    """A finished experiment."""
    return finished(seeds=2)


def test_the_matrix_has_every_reward_of_the_experiment(harness, experiment):
    """`--all` scores every training under every reward, and its diagonal is what was recorded."""
    matrix = harness("score mine --all --json").json["matrices"][0]
    combination = harness("report mine --json").json["combinations"][0]
    assert set(matrix["indices"]) == {"baseline", "arp"}
    assert matrix["indices"]["baseline"]["baseline"] == combination["baseline_index"]
    assert matrix["indices"]["arp"]["arp"] == combination["proposed_index"]


def test_scores_stand_beside_the_trace(harness, experiment, tmp_path):
    """Each cell gets scores.parquet with a column per reward and a row per recorded row; the trace stays."""
    cell = next((tmp_path / "mine" / "cells").glob("[!.]*"))
    before = (cell / "trace.parquet").read_bytes()
    harness("score mine --reward arp:k2=2,dense")
    scores = pq.read_table(cell / "scores.parquet")
    assert scores.column_names == ["arp:k2=2", "dense"]
    assert scores.num_rows == pq.read_metadata(cell / "trace.parquet").num_rows
    assert (cell / "trace.parquet").read_bytes() == before


def test_the_paid_reward_is_reproduced_exactly(harness, experiment, tmp_path):
    """Scored by the reward that paid it, a trace gives its own column bit for bit."""
    harness("score mine --all")
    for cell in (tmp_path / "mine" / "cells").glob("[!.]*"):
        reward = json.loads((cell / "manifest.json").read_text())["cell"]["reward"]["label"]
        paid = pq.read_table(cell / "trace.parquet", columns=["reward"])["reward"].to_numpy()
        assert (pq.read_table(cell / "scores.parquet")[reward].to_numpy() == paid).all()


def test_the_table_names_both_indices(harness, experiment, tmp_path):
    """Without --json there is a table of I_N and one of I_P; brackets in the folder's name are no markup."""
    (tmp_path / "mine").rename(tmp_path / "mine [report]")
    out = harness("score 'mine [report]' --reward arp").out
    assert "I_N" in out
    assert "I_P" in out
    assert "mine [report]/cells\n" in out


def test_files_are_scored_beside_themselves(harness, experiment, tmp_path):
    """Recorded files are taken by pattern; --out collects the scores."""
    answer = harness("score 'mine/cells/*/trace.parquet' --reward arp --json")
    assert answer.status == 0
    assert all((tmp_path / entry["scores"]).exists() for entry in answer.json["files"])
