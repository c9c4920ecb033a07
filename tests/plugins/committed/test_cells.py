"""One row per cell."""

import csv
from io import StringIO

import numpy as np
import pytest

from harness.record.folder import TRACE
from harness.record.trace import read_trace
from harness_plugins.committed.tables import write_cells


def rows(results):
    """Every row by its columns."""
    return list(csv.DictReader(StringIO(write_cells(results), newline="")))


def test_rows_are_in_the_order_of_the_plan(build):
    """Whatever ended first, and however."""
    results = build(ended={("baseline", 0): ("failed", "it broke"), ("arp", 1): ("pending", "")})
    assert [row["id"] for row in rows(results)] == [cell.id for cell in results.store.read_plan().cells]


def test_indices_are_those_of_the_run_alone(build):
    """Not of the mean: the run of seed 1 climbs faster than that of seed 0."""
    first, _, second, *_ = rows(build())
    assert (first["reward"], first["first_negative"], first["crossover"]) == ("baseline", "1", "18")
    assert (second["seed"], second["crossover"]) == ("1", "18")
    assert float(first["I_N"]) == pytest.approx(-81.0)
    assert float(second["I_P"]) > float(first["I_P"])


def test_numbers_are_read_back_exactly(build):
    """The accumulated reward, the metrics and the times, to the last bit."""
    results = build()
    for row, manifest in zip(rows(results), results.manifests, strict=True):
        reward = read_trace(results.store.cell_folder(manifest.cell) / TRACE, ["reward"])["reward"]
        assert float(row["final_accumulated_reward"]) == np.cumsum(reward)[-1]
        assert float(row["seconds"]) == manifest.seconds
        for name, value in results.measured(manifest.cell).own.items():
            if not name.startswith("random_"):
                assert row[name] == "" if value is None else float(row[name]) == value


def test_failed_cell_has_its_reason_and_no_values(build):
    """A reason of several lines stands in one."""
    results = build(ended={("arp", 0): ("failed", 'it "broke",\nbadly')})
    row = rows(results)[1]
    assert (row["status"], row["reason"]) == ("failed", 'it "broke", badly')
    known = ("id", "simulator", "task", "robot", "algorithm", "reward", "seed", "steps", "status", "reason")
    assert {row[name] for name in row if name not in known} == {""}


def test_what_never_happens_is_empty(build):
    """A run that is never negative has no such step."""
    row = rows(build(baseline=(0, 39)))[0]
    assert (row["first_negative"], row["crossover"], row["I_N"]) == ("", "", "0.0")


def test_lines_end_alike_everywhere(build):
    """With a line feed alone, on every system."""
    text = write_cells(build())
    assert "\r" not in text
    assert text.endswith("\n")


@pytest.mark.parametrize("reason", ["=1+1", "+1", "-1", "@SUM(A1)", "=HYPERLINK()"])
def test_a_text_is_no_formula(build, reason):
    """A spreadsheet shows it, behind an apostrophe, and computes nothing."""
    row = rows(build(ended={("arp", 0): ("failed", reason)}))[1]
    assert row["reason"] == f"'{reason}"


def test_negative_numbers_stay_numbers(build):
    """What begins with a sign is a formula only if it is a text."""
    assert float(rows(build())[0]["I_N"]) < 0.0


def test_hidden_characters_are_written_out(build):
    """No reader obeys them."""
    row = rows(build(ended={("arp", 0): ("failed", "\x1b[2J\u202e")}))[1]
    assert row["reason"] == "\\x1b[2J\\u202e"
