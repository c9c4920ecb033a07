"""`results.parquet`, written and found whole."""

from collections.abc import Callable
from pathlib import Path

import pyarrow.parquet as pq

from harness.files.sums import changed_since_made
from harness.record.cell import Cell
from harness.record.manifest import Manifest
from harness.record.store import RESULTS
from harness.results.measured import STOCHASTIC, Measured
from harness.results.table import Numbers, numbers_of, table_of, write_table

MakeCell = Callable[..., Cell]


def test_row_of_a_done_cell_has_its_own_metrics_and_those_of_random_actions(make_cell: MakeCell):
    """Of the manner that stands first."""
    measured = Measured({STOCHASTIC: {"success_rate": 0.5}}, {STOCHASTIC: 10}, {"success_rate": 0.1})
    (row,) = table_of([(Manifest(make_cell(), status="done"), numbers_of(measured, ["success_rate"]))]).to_pylist()
    assert (row["id"], row["status"]) == (make_cell().id, "done")
    assert (row["success_rate"], row["random_success_rate"]) == (0.5, 0.1)


def test_row_of_a_cell_that_is_not_done_has_no_metrics(make_cell: MakeCell):
    """It says why."""
    failed = Manifest(make_cell(), status="failed", reason="no luck")
    (row,) = table_of([(failed, None)], ["success_rate"]).to_pylist()
    assert (row["status"], row["reason"], row["success_rate"]) == ("failed", "no luck", None)


def test_table_takes_the_place_of_an_earlier_one(make_cell: MakeCell, tmp_path: Path):
    """With its digest."""
    for seeds in (1, 2):
        manifests = [Manifest(make_cell(seed=seed), status="pending") for seed in range(seeds)]
        write_table(tmp_path, [(manifest, None) for manifest in manifests], ["success_rate"])
        assert pq.read_table(tmp_path / RESULTS).num_rows == seeds
        assert changed_since_made(tmp_path) == []


def test_numbers_that_one_cell_alone_has_are_a_column(make_cell: MakeCell):
    """The others have none there; why is told."""
    done = [Manifest(make_cell(seed=seed), status="done") for seed in range(2)]
    numbers = [Numbers({"return_own": 1.0}), Numbers({"behaviour_success": None}, {"success": "no episode ended"})]
    first, second = table_of(zip(done, numbers, strict=True)).to_pylist()
    assert (first["return_own"], first["behaviour_success"], second["return_own"]) == (1.0, None, None)
    assert (first["not_measured"], second["not_measured"]) == ("", "success: no episode ended")
