"""Ratios of `make bench` are kept, and drawn over time."""

import json
from dataclasses import replace

import pytest

from tests.bench.records import FIGURE, Record, draw_records, main, read_records
from tests.project import ROOT

KEPT = ROOT / "results" / "reference" / "bench"
RECORD = Record(
    "2026-01-31", "0.1.0", "12345678", "a CPU, 2 cores", {}, {"mujoco: one env": {"ratio": 0.8, "at_least": 0.4}}
)


def test_a_run_becomes_a_record_and_a_figure(tmp_path):
    """With the machine, the commit and the packages behind it."""
    ratios = {"mujoco: one env": {"ratio": 0.8, "at_least": 0.6}}
    (tmp_path / "bench.json").write_text(json.dumps(ratios))
    main(tmp_path / "bench.json", tmp_path / "kept")
    (record,) = read_records(tmp_path / "kept")
    assert record.ratios == ratios
    assert "cores" in record.machine
    assert record.versions["numpy"]
    assert (tmp_path / "kept" / FIGURE).read_bytes() == draw_records([record])


def test_the_figure_shows_the_last_three_records():
    """Each ratio by its bound; who points at a dot reads of which record it is."""
    figure = draw_records([replace(RECORD, date=f"2026-0{month}-01") for month in range(1, 6)]).decode()
    assert [f"2026-0{month}-01" in figure for month in range(1, 6)] == [False, False, True, True, True]
    assert "mujoco: one env: 0.8" in figure


def test_a_timing_that_the_last_record_lacks_is_not_drawn():
    """It has been given up or renamed."""
    old = replace(RECORD, ratios={"gone": {"ratio": 1.0, "at_least": 0.5}, **RECORD.ratios})
    assert "gone" not in draw_records([old, RECORD]).decode()


def test_the_committed_figure_is_that_of_the_committed_records():
    """`make bench-record` draws it."""
    records = read_records(KEPT)
    assert records
    assert (KEPT / FIGURE).read_bytes() == draw_records(records)


@pytest.mark.parametrize("record", read_records(KEPT), ids=lambda record: record.date)
def test_committed_ratios_were_above_their_bounds(record):
    """A record of a run that failed is none."""
    assert all(it["ratio"] >= it["at_least"] for it in record.ratios.values())
