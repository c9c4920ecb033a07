"""What an experiment's folder says, as data and as a table."""

import json
import re
import subprocess
import sys

import pyarrow.parquet as pq
import pytest

import harness
from harness import load_results
from harness.errors import UsageError
from harness.results.table import comparison_rows
from tests.results.folders import ARP, fail
from tests.stores import create_store


def test_json_has_the_promised_keys(experiment):
    """What `harness report --json` promises is there, under these names, and what is added is named here."""
    data = experiment.to_json()
    assert set(data) == {
        *("format", "baseline", "curve", "combinations", "cells", "not_measured", "equal_trainings", "over_places"),
        *("terms", "recovered"),
    }
    assert data["format"] == 2
    (combination,), (cell, *_) = data["combinations"], data["cells"]
    assert set(combination) == {
        *("simulator", "algorithm", "robot", "task", "steps", "deterministic", "baseline", "proposed", "is_control"),
        *("seeds", "trained", "mixtures", "headline", "eta_N", "eta_P", "total", "baseline_index", "proposed_index"),
        *("claims", "episodes", "behaviour", "along_the_budget"),
        *("deciding", "decided_in", "returns", "returns_missing", "test", "same_steps"),
        *("paid_at_random", "not_maximised"),
    }
    told = {"answer", "behaviour", "pay", "number", "decided_by", "seeds_to_decide"}
    assert set(combination["headline"]) == told
    ratios = {"eta", "per_seed", "ruler", "behaviour", "interaction", "noise"}
    for name in ("eta_N", "eta_P"):
        assert set(combination[name]) == ratios | {"paths", "p", "p_corrected", "flags"}
        assert set(combination[name]["eta"]) == {"value", "low", "high", "seeds", "note"}
    assert set(combination["total"]) == {"change", "ruler", "behaviour"}
    for index in (combination["baseline_index"], combination["proposed_index"]):
        assert set(index) == {"first_negative", "crossover", "steps", "I_N", "I_P", "total"}
    assert set(cell) == {
        *("id", "simulator", "algorithm", "reward", "seed", "status", "reason", "seconds", "steps", "task")
    }


def test_json_is_strict(experiment):
    """No NaN, no infinity, nothing that is not plain data."""
    data = experiment.to_json()
    assert json.loads(json.dumps(data, allow_nan=False)) == data


def test_combination_is_named(experiment):
    """By the labels of what was chosen."""
    (combination,) = experiment.to_json()["combinations"]
    kinds = ("simulator", "algorithm", "robot", "task", "baseline", "proposed", "steps")
    named = ["ideal", "wander", "fd100", "fd100-reach:horizon=5", "baseline", "arp", 12]
    assert [combination[kind] for kind in kinds] == named


def test_json_of_a_combination_always_has_the_same_keys(experiment, both, make_plan, tmp_path):
    """Also where there is nothing to compare, and where a cell failed."""
    store = create_store(tmp_path / "other", make_plan(*both(1)))
    fail(store, both(1)[0], 'a "quoted" reason')
    told = load_results(store.folder).to_json()
    ((full,), (empty,)) = (data["combinations"] for data in (experiment.to_json(), told))
    assert list(empty) == list(full)
    assert 'a \\"quoted\\" reason' in json.dumps(told, allow_nan=False)


def test_table_has_a_row_per_cell(experiment, make_cell):
    """`results.parquet`: what is known of each cell, and every metric of the policy and of random actions."""
    fail(experiment.store, make_cell(seed=2, reward=ARP), "no luck")
    results = load_results(experiment.folder)
    path = results.write_table()
    table = pq.read_table(path)
    metrics = sorted(results.metrics)
    assert path == experiment.folder / "results.parquet"
    assert table.column_names == [
        *["id", "simulator", "algorithm", "reward", "seed", "status", "reason", "seconds", "steps", "robot", "task"],
        "not_measured",
        *metrics,
        *(f"random_{name}" for name in metrics),
    ]
    assert table.num_rows == 6
    rows = {(row["reward"], row["seed"]): row for row in table.to_pylist()}
    assert rows["baseline", 0]["success_rate"] == 1.0
    assert rows["baseline", 0]["random_success_rate"] == 0.0
    assert rows["arp", 2]["success_rate"] is None
    assert rows["arp", 2]["status"] == "failed"


def test_table_of_cells_that_have_not_run(make_cell, made):
    """A metric's column is of numbers, also where there is none yet; a notebook gets no table of nothing."""
    results = made([make_cell()], lambda cell: None)
    assert str(pq.read_schema(results.write_table()).field("success_rate").type) == "double"
    assert results._repr_html_().startswith("<p>&lt;Results of ")


def test_damaged_trace_is_named(experiment, make_cell):
    """A cell with a file that is not what was written is damaged, and no number of it is read; the others are."""
    (experiment.store.cell_folder(make_cell()) / "trace.parquet").write_bytes(b"PAR1")
    results = load_results(experiment.folder)
    [damaged] = results.damaged
    assert damaged.cell == make_cell()
    assert re.search(rf"{make_cell().id}/trace\.parquet is not what was written", damaged.reason)
    assert make_cell() not in results.done_cells
    assert results.combinations


def test_load_results_is_public(experiment):
    """`harness.load_results` takes a path as text."""
    assert harness.load_results(str(experiment.folder)).baseline == "baseline"


def test_reading_results_imports_no_engine_and_unpickles_nothing(experiment):
    """In a fresh process: years later, on another machine, a folder is read without what made it."""
    (experiment.folder / "cells" / ".gone.partial").mkdir()
    script = (
        "import sys, harness\n"
        "unpickled = []\n"
        "sys.addaudithook(lambda event, args: event == 'pickle.find_class' and unpickled.append(args))\n"
        "results = harness.load_results(sys.argv[1])\n"
        "assert results.to_json()['combinations'][0]['seeds'] == [0, 1, 2]\n"
        "results.write_table()\n"
        "heavy = {'torch', 'mujoco', 'stable_baselines3', 'pybullet', 'dm_control'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
        "assert not unpickled, unpickled\n"
    )
    command = [sys.executable, "-c", script, str(experiment.folder)]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr


def test_repr_says_where_and_how_many(experiment):
    """In one line, without computing anything."""
    assert repr(experiment) == f"<Results of '{experiment.folder}': 6 cells (6 done)>"


def test_notebook_gets_a_table(experiment):
    """A row per comparison under the headings; no name is markup."""
    shown = experiment._repr_html_()
    assert shown.count("<tr>") == 1 + len(experiment.combinations)
    assert "<th>eta_P</th>" in shown
    assert "<Results" not in shown


@pytest.mark.parametrize("asked", ["to_pandas", "comparisons"])
def test_pandas_that_is_missing_is_told(experiment, monkeypatch, asked):
    """In one line, with what to type."""
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(UsageError, match=f"{asked} needs pandas: pip install pandas"):
        getattr(experiment, asked)()


def test_pandas_gets_a_row_per_cell(experiment):
    """The columns are those of the file."""
    pytest.importorskip("pandas", reason="pandas is not installed")
    frame = experiment.to_pandas()
    assert list(frame.columns) == pq.read_table(experiment.write_table()).column_names
    assert list(frame["status"]) == ["done"] * 6


def test_comparisons_are_a_data_frame(experiment):
    """A row for each."""
    pytest.importorskip("pandas", reason="pandas is not installed")
    frame = experiment.comparisons()
    assert list(frame.columns) == comparison_rows([]).schema.names
    assert list(frame["proposed"]) == [it.proposed for it in experiment.combinations]
