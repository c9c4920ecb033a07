import json

import pytest


@pytest.fixture
def experiment(harness, quick):
    """A finished experiment."""
    harness("run", *quick, "--seeds", "2", "--out", "mine")
    return "mine"


def test_json_is_all_that_goes_to_standard_output(harness, experiment):
    """`--json` prints one JSON document with the combinations and the cells."""
    answer = harness("report", experiment, "--json")
    data = json.loads(answer.out)
    assert set(data) == {"combinations", "cells", "evaluation_returns"}
    assert len(data["cells"]) == 4
    assert answer.err == ""


def test_the_table_is_the_default(harness, experiment):
    """Without a flag the table goes to standard output."""
    assert "eta_N" in harness("report", experiment).out


def test_html_goes_where_it_is_told(harness, experiment, tmp_path):
    """`--html FILE` writes the page."""
    answer = harness("report", experiment, "--html", "page.html")
    assert answer.status == 0
    assert "<html" in (tmp_path / "page.html").read_text()


def test_a_folder_that_is_no_experiment_is_refused(harness, tmp_path):
    """A wrong folder ends with status 2 and one line."""
    answer = harness("report", tmp_path)
    assert (answer.status, answer.err.count("\n")) == (2, 1)
    assert "is no experiment" in answer.err


def test_a_damaged_cell_is_told_in_one_line(harness, experiment, tmp_path):
    """A trace that is cut short ends with the file's name, not with a traceback."""
    trace = next((tmp_path / experiment / "cells").glob("*/trace.parquet"))
    trace.write_bytes(trace.read_bytes()[:100])
    answer = harness("report", experiment, "--json")
    assert (answer.status, answer.err.count("\n")) == (1, 1)
    assert "trace.parquet" in answer.err
