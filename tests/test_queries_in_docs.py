"""The queries that docs/folders.md shows."""

import re

import pyarrow.parquet as pq
import pytest

from harness.record import EVALUATION, RESULTS, TRACE
from tests.project import ROOT

PAGE = ROOT / "docs" / "folders.md"


def _queries():
    yield from re.findall(r'duckdb -c "([^"]*)"', PAGE.read_text())


QUERIES = list(_queries())


@pytest.fixture
def folder(make_cell, make_plan, run_here, tmp_path):
    """Two seeds of one reward."""
    results = run_here(make_plan(make_cell(seed=0), make_cell(seed=1)), tmp_path / "mine")
    results.write_table()
    return results.folder


def test_there_are_queries():
    """On the page."""
    assert len(QUERIES) == 3


def test_columns_of_the_queries_are_there(folder):
    """In the table of cells, and in the traces."""
    assert {"id", "reward", "seed", "status", "success_rate", "random_success_rate"} <= _columns(folder / RESULTS)
    for name in (TRACE, EVALUATION):
        for path in folder.glob(f"cells/*/{name}"):
            assert {"reward", "distance", "terminated", "truncated"} <= _columns(path)


def _columns(path):
    return set(pq.read_schema(path).names)


@pytest.mark.parametrize("query", QUERIES)
def test_query_answers(folder, query):
    """As DuckDB reads it, where that is installed."""
    rows = pytest.importorskip("duckdb").sql(re.sub(r"'DIR/", f"'{folder.as_posix()}/", query)).fetchall()
    assert rows
    assert all(value is not None for row in rows for value in row)
