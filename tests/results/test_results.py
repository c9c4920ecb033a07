"""What an experiment's folder says, as data and as a table."""

import json
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

import harness
from harness.errors import UsageError
from harness.experiment.plan import Plan
from harness.record.cell import Cell
from harness.record.folder import TRACE
from harness.record.store import CELLS, RESULTS, Store
from harness.registry.registry import Registry
from harness.results import Results, load_results
from harness.results.table import SCHEMA
from tests.results.folders import ARP, fail

MakeCell = Callable[..., Cell]
MakePlan = Callable[..., Plan]


def test_json_has_the_promised_keys(experiment: Store, registry: Registry):
    """What `harness report --json` promises is there, under these names, and what is added is named here."""
    data = Results(experiment.folder, registry).to_json()
    assert set(data) == {"format", "baseline", "curve", "combinations", "cells", "not_measured", "equal_trainings"} | {
        "over_places",
        "terms",
    }
    assert data["format"] == 1
    combination, cell = data["combinations"][0], data["cells"][0]
    assert set(combination) == {
        *("simulator", "algorithm", "robot", "task", "steps", "deterministic", "baseline", "proposed", "is_control"),
        *("seeds", "trained", "mixtures", "headline", "eta_N", "eta_P", "total", "baseline_index", "proposed_index"),
        *("claims", "smallest_p", "episodes", "behaviour", "along_the_budget"),
        *("deciding", "decided_in", "returns", "returns_missing", "test", "same_steps"),
        *("paid_at_random", "not_maximised"),
    }
    told = {"answer", "behaviour", "robot", "pay", "number", "decided_by", "seeds_to_decide"}
    assert set(combination["headline"]) == told
    ratios = {"eta", "per_seed", "ruler", "behaviour", "interaction", "noise"}
    for name in ("eta_N", "eta_P"):
        assert set(combination[name]) == ratios | {"paths", "p", "p_corrected", "flags"}
        assert set(combination[name]["eta"]) == {"value", "low", "high", "note"}
    assert set(combination["total"]) == {"change", "ruler", "behaviour"}
    for index in (combination["baseline_index"], combination["proposed_index"]):
        assert set(index) == {"first_negative", "crossover", "steps", "I_N", "I_P", "total"}
    assert set(cell) == {
        "id",
        "simulator",
        "algorithm",
        "reward",
        "seed",
        "status",
        "reason",
        "seconds",
        "steps",
        "task",
    }


def test_json_is_strict(experiment: Store, registry: Registry):
    """No NaN, no infinity, nothing that is not plain data."""
    data = Results(experiment.folder, registry).to_json()
    assert json.loads(json.dumps(data, allow_nan=False)) == data


def test_combination_is_named(experiment: Store, registry: Registry):
    """By the labels of what was chosen."""
    (combination,) = Results(experiment.folder, registry).to_json()["combinations"]
    named = {key: combination[key] for key in ("simulator", "algorithm", "robot", "task", "baseline", "proposed")}
    assert named == {
        "simulator": "ideal",
        "algorithm": "wander",
        "robot": "fd100",
        "task": "fd100-reach:horizon=5",
        "baseline": "baseline",
        "proposed": "arp",
    }
    assert combination["steps"] == 12


def test_json_of_a_combination_always_has_the_same_keys(
    experiment: Store, make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """Also where there is nothing to compare."""
    store = Store.create(tmp_path / "other", make_plan(make_cell(), make_cell(reward=ARP)))
    (full,), (empty,) = (Results(one.folder, registry).to_json()["combinations"] for one in (experiment, store))
    assert list(empty) == list(full)
    assert json.dumps(empty, allow_nan=False)


def test_json_of_any_folder_can_be_printed(experiment: Store, make_cell: MakeCell, registry: Registry):
    """Also with failed cells in it."""
    fail(experiment, make_cell(), 'a "quoted" reason')
    data: dict[str, Any] = Results(experiment.folder, registry).to_json()
    assert 'a \\"quoted\\" reason' in json.dumps(data)


def test_table_has_a_row_per_cell(experiment: Store, make_cell: MakeCell, registry: Registry):
    """`results.parquet`: what is known of each cell, and every metric of the policy and of random actions."""
    fail(experiment, make_cell(seed=2, reward=ARP), "no luck")
    results = Results(experiment.folder, registry)
    path = results.write_table()
    table = pq.read_table(path)
    metrics = sorted(results.metrics)
    assert path == experiment.folder / RESULTS
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


def test_table_of_cells_that_have_not_run(make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path):
    """A metric's column is of numbers, also where there is none yet."""
    store = Store.create(tmp_path, make_plan(make_cell()))
    schema = pq.read_schema(Results(store.folder, registry).write_table())
    assert str(schema.field("success_rate").type) == "double"


def test_damaged_trace_is_named(experiment: Store, make_cell: MakeCell, registry: Registry):
    """A cell with a file that is not what was written is damaged, and no number of it is read; the others are."""
    (experiment.cell_folder(make_cell()) / TRACE).write_bytes(b"PAR1")
    results = Results(experiment.folder, registry)
    [damaged] = results.damaged
    assert damaged.cell == make_cell()
    assert re.search(rf"{make_cell().id}/trace\.parquet is not what was written", damaged.reason)
    assert make_cell() not in results.done_cells
    assert results.combinations


def test_other_folders_are_no_results(tmp_path: Path):
    """A folder without an experiment is a usage error."""
    with pytest.raises(UsageError, match="is no experiment"):
        load_results(tmp_path)


def test_load_results_is_public(experiment: Store):
    """`harness.load_results` takes a path as text."""
    assert harness.load_results(str(experiment.folder)).baseline == "baseline"


def test_reading_results_imports_no_engine_and_unpickles_nothing(experiment: Store):
    """In a fresh process: years later, on another machine, a folder is read without what made it."""
    (experiment.folder / CELLS / ".gone.partial").mkdir()
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


def test_repr_says_where_and_how_many(experiment: Store, registry: Registry):
    """In one line, without computing anything."""
    assert repr(Results(experiment.folder, registry)) == f"<Results of '{experiment.folder}': 6 cells (6 done)>"


def test_notebook_gets_a_table(experiment: Store, registry: Registry):
    """A row per comparison under the headings; no name is markup."""
    results = Results(experiment.folder, registry)
    shown = results._repr_html_()
    assert shown.count("<tr>") == 1 + len(results.combinations)
    assert "<th>eta_P</th>" in shown
    assert "<Results" not in shown


def test_notebook_gets_no_table_of_nothing(
    make_cell: MakeCell, make_plan: MakePlan, registry: Registry, tmp_path: Path
):
    """The one line stands there alone."""
    Store.create(tmp_path, make_plan(make_cell()))
    assert Results(tmp_path, registry)._repr_html_().startswith("<p>&lt;Results of ")


def test_pandas_that_is_missing_is_told(experiment: Store, registry: Registry, monkeypatch: pytest.MonkeyPatch):
    """In one line, with what to type."""
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(UsageError, match="pip install pandas"):
        Results(experiment.folder, registry).to_pandas()


def test_pandas_gets_a_row_per_cell(experiment: Store, registry: Registry):
    """The columns are those of the file."""
    pytest.importorskip("pandas", reason="pandas is not installed")
    results = Results(experiment.folder, registry)
    frame = results.to_pandas()
    results.write_table()
    assert list(frame.columns) == pq.read_table(experiment.folder / RESULTS).column_names
    assert list(frame["status"]) == ["done"] * 6


def test_comparisons_without_pandas_are_told(experiment: Store, registry: Registry, monkeypatch: pytest.MonkeyPatch):
    """In one line, as `to_pandas` does."""
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(UsageError, match="comparisons needs pandas: pip install pandas"):
        Results(experiment.folder, registry).comparisons()


def test_comparisons_are_a_data_frame(experiment: Store, registry: Registry):
    """A row for each."""
    pytest.importorskip("pandas", reason="pandas is not installed")
    results = Results(experiment.folder, registry)
    frame = results.comparisons()
    assert list(frame.columns) == SCHEMA.names
    assert list(frame["proposed"]) == [it.proposed for it in results.combinations]
