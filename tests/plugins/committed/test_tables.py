"""The tables of a summary."""

import csv
from io import StringIO

import numpy as np
import pyarrow.parquet as pq
import pytest

from harness.eta import BB, BK, KB, KK
from harness.record import TRACE, read_trace
from harness_plugins.committed import write_summary
from tests.report.conftest import NO_PAIR


@pytest.fixture
def left(tmp_path):
    """A file of the summary of some results."""

    def write(results, name):
        write_summary(results, tmp_path / "left")
        return tmp_path / "left" / name

    return write


@pytest.fixture
def rows(left):
    """Every row of the cells by its columns."""
    return lambda results: list(csv.DictReader(StringIO(left(results, "cells.csv").read_text(), newline="")))


def test_rows_are_in_the_order_of_the_plan(build, rows):
    """Whatever ended first, and however."""
    results = build(ended={("baseline", 0): ("failed", "it broke"), ("arp", 1): ("pending", "")})
    assert [row["id"] for row in rows(results)] == [cell.id for cell in results.store.read_plan().cells]


def test_indices_are_those_of_the_run_alone(build, rows):
    """Not of the mean: the run of seed 1 climbs faster than that of seed 0."""
    first, _, second, *_ = rows(build())
    assert (first["reward"], first["first_negative"], first["crossover"]) == ("baseline", "1", "18")
    assert (second["seed"], second["crossover"]) == ("1", "18")
    assert float(first["I_N"]) == pytest.approx(-81.0)
    assert float(second["I_P"]) > float(first["I_P"])


def test_numbers_are_read_back_exactly(build, rows):
    """The accumulated reward, the metrics and the times, to the last bit."""
    results = build()
    for row, manifest in zip(rows(results), results.manifests, strict=True):
        reward = read_trace(results.store.cell_folder(manifest.cell) / TRACE)["reward"]
        assert float(row["final_accumulated_reward"]) == np.cumsum(reward)[-1]
        assert float(row["seconds"]) == manifest.seconds
        for name, value in results.measured(manifest.cell).own.items():
            if not name.startswith("random_"):
                assert row[name] == "" if value is None else float(row[name]) == value


def test_failed_cell_has_its_reason_and_no_values(build, rows):
    """A reason of several lines stands in one."""
    row = rows(build(ended={("arp", 0): ("failed", 'it "broke",\nbadly')}))[1]
    assert (row["status"], row["reason"]) == ("failed", 'it "broke", badly')
    known = ("id", "simulator", "task", "robot", "algorithm", "reward", "seed", "steps", "status", "reason")
    assert {row[name] for name in row if name not in known} == {""}


def test_what_never_happens_is_empty(build, rows):
    """A run that is never negative has no such step."""
    row = rows(build(baseline=(0, 39)))[0]
    assert (row["first_negative"], row["crossover"], row["I_N"]) == ("", "", "0.0")


def test_lines_end_alike_everywhere(build, left):
    """With a line feed alone, on every system."""
    text = left(build(), "cells.csv").read_bytes()
    assert b"\r" not in text
    assert text.endswith(b"\n")


@pytest.mark.parametrize("reason", ["=1+1", "+1", "-1", "@SUM(A1)", "=HYPERLINK()"])
def test_a_text_is_no_formula(build, reason, rows):
    """A spreadsheet shows it, behind an apostrophe, and computes nothing."""
    assert rows(build(ended={("arp", 0): ("failed", reason)}))[1]["reason"] == f"'{reason}"


def test_negative_numbers_stay_numbers(build, rows):
    """What begins with a sign is a formula only if it is a text."""
    assert float(rows(build())[0]["I_N"]) < 0.0


def test_hidden_characters_are_written_out(build, rows):
    """No reader obeys them."""
    row = rows(build(ended={("arp", 0): ("failed", "\x1b[2J\u202e")}))[1]
    assert row["reason"] == "\\x1b[2J\\u202e"


LABELS = {"baseline": "baseline", "proposed": "arp"}


@pytest.fixture
def read(left):
    """The table of curves, and its rows by (scored by, trained with)."""

    def curves(results):
        table = pq.read_table(left(results, "curves.parquet"))
        found = {}
        for row in table.to_pylist():
            found.setdefault((row["scored_by"], row["trained_with"]), []).append(row)
        return table, found

    return curves


@pytest.mark.parametrize("runs", [((9, 30), (5, 34)), ((20_000, 35_000), (9_000, 46_000))])
def test_indices_follow_from_the_curves(build, runs, read):
    """I_N and I_P of all four pairs: to the digits kept of a short run, within 1 % of a long one."""
    results = build(baseline=runs[0], proposed={"arp": runs[1]})
    (combination,) = results.combinations
    _, curves = read(results)
    for pair in (BB, BK, KB, KK):
        rows, index = curves[LABELS[pair[0]], LABELS[pair[1]]], combination.curves[pair].index
        sums = [sum(pick(row["value"], 0.0) * row["every"] for row in rows) for pick in (min, max)]
        within = 1e-6 if rows[0]["every"] == 1 else 0.01
        assert sums == pytest.approx([index.negative_sum, index.positive_sum], rel=within)


def test_long_curve_is_thinned(build, read):
    """To so many rows at most, over all of its steps, a whole number of steps apart."""
    _, curves = read(build(seeds=1, baseline=(20_000, 35_000)))
    rows = curves["baseline", "baseline"]
    (every,) = {row["every"] for row in rows}
    assert 600 < len(rows) <= 1_200
    assert [row["step"] for row in rows] == list(range(0, 55_001, every))


def test_shared_curve_stands_once(build, read):
    """Two rewards compared with one baseline over the same seeds share its curve."""
    _, curves = read(build(proposed={"arp": (9, 30), "relative": (9, 30)}))
    assert [row["step"] for row in curves["baseline", "baseline"]] == list(range(40))


def test_curves_over_other_seeds_stand_apart(build, read):
    """Where a run failed, the baseline is compared over the seeds that are left."""
    _, curves = read(build(proposed={"arp": (9, 30), "relative": (9, 30)}, ended={("arp", 1): ("failed", "it broke")}))
    assert {row["seeds"] for row in curves["baseline", "baseline"]} == {"0 2", "0 1 2"}


def test_null_control_has_curves_of_its_own(build, read):
    """The baseline trained again does not stand where the baseline's runs are looked for."""
    results = build(a_a=True)
    asked, control = results.combinations
    _, curves = read(results)
    for trained, curve in (("baseline", asked.curves[BB]), ("baseline (other seeds)", control.curves[KK])):
        assert curve.index.positive_sum == pytest.approx(
            sum(max(row["value"], 0.0) * row["every"] for row in curves["baseline", trained]), rel=1e-6
        )


def test_unscored_runs_have_their_own_curves(build, read):
    """A reward that is gone scores nothing; what its runs were paid is there."""
    _, curves = read(build(proposed={"gone": (9, 30)}))
    assert set(curves) == {("baseline", "baseline"), ("gone", "gone")}


def test_no_finished_pair_no_rows(build, read):
    """The columns are there, and what they mean."""
    table, _ = read(build(**NO_PAIR))
    assert table.num_rows == 0
    assert table.column_names[-1] == "value"
    assert b"n is the column 'every'" in table.schema.metadata[b"about"]
