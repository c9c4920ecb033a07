"""`results.parquet`, written and found whole; and the comparisons as a table."""

from dataclasses import replace

import pyarrow.parquet as pq

from harness.files.bounded import changed_since_made
from harness.record import Manifest
from harness.results.compare import with_verdicts
from harness.results.table import Numbers, comparison_rows, table_of, write_table
from tests.results.told import comparison, rates


def test_numbers_that_one_cell_alone_has_are_a_column(make_cell):
    """The others have none there; why is told, and why a cell is not done."""
    done = [Manifest(make_cell(seed=seed), status="done") for seed in range(2)]
    failed = Manifest(make_cell(seed=2), status="failed", reason="no luck")
    numbers = [
        Numbers({"return_own": 1.0}),
        Numbers({"behaviour_success": None}, {"success": "no episode ended"}),
        None,
    ]
    first, second, third = table_of([*zip([*done, failed], numbers, strict=True)]).to_pylist()
    assert (first["return_own"], first["behaviour_success"], second["return_own"]) == (1.0, None, None)
    assert (first["not_measured"], second["not_measured"]) == ("", "success: no episode ended")
    assert (third["status"], third["reason"], third["return_own"]) == ("failed", "no luck", None)


def test_table_takes_the_place_of_an_earlier_one(make_cell, tmp_path):
    """With its digest."""
    for seeds in (1, 2):
        manifests = [Manifest(make_cell(seed=seed), status="pending") for seed in range(seeds)]
        path = write_table(tmp_path, [(manifest, None) for manifest in manifests], ["success_rate"])
        assert pq.read_table(path).num_rows == seeds
        assert changed_since_made(tmp_path) == []


(COMPARED,) = with_verdicts([comparison("arp", {"success_rate": rates(0.5, 0.9)})])


def row_of(compared):
    """The one row of its table."""
    (row,) = comparison_rows([compared]).to_pylist()
    return row


def test_row_has_the_place_the_answer_its_test_and_the_numbers():
    """As the comparison does, as exact as they are known."""
    row, change, ruling = row_of(COMPARED), COMPARED.decisive, COMPARED.answer.ruling
    named = (row["simulator"], row["task"], row["baseline"], row["proposed"], row["seeds"], row["steps"])
    assert named == ("mujoco", "reach", "baseline", "arp", 20, 1000)
    assert (row["answer"], row["p"], row["p_corrected"]) == ("helps", ruling.p, ruling.corrected)
    assert (row["measure"], row["difference"]) == (change.name, change.difference)
    assert row["eta_P"] is None


def test_row_of_a_run_has_its_etas(experiment):
    """And the ruler of each."""
    (compared,) = experiment.combinations
    row = row_of(compared)
    assert (row["eta_P"], row["ruler"]) == (compared.number.eta_p.value, compared.number.splits["eta_P"].ruler.value)


def test_what_is_not_known_is_null():
    """An environment has no robot; before a ruling there is no p."""
    (interim,) = with_verdicts([COMPARED], to_come=1)
    row = row_of(replace(interim, group=interim.group._replace(robot="", simulator=None)))
    assert (row["p"], row["simulator"]) == (None, None)


def test_empty_table_has_all_columns():
    """So that a program that reads it need not ask."""
    assert comparison_rows([]).schema == comparison_rows([COMPARED]).schema


def test_row_counts_the_trainings_of_each_reward():
    """They need not be as many, nor have seeds in common."""
    row = row_of(replace(COMPARED, trained=((0, 1, 2), (1, 2))))
    assert (row["baseline_trainings"], row["proposed_trainings"]) == (3, 2)
