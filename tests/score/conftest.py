"""What tests of scores write: a trace of one joint, with its manifest."""

import numpy as np
import pytest

from harness.record import COLUMN, SCALARS, Manifest, TraceWriter


def _write_trace(folder, cell, columns):
    rows = np.zeros((len(columns["step"]), len(SCALARS) + 2))
    for name, values in columns.items():
        rows[:, COLUMN[name]] = values
    path = folder / "trace.parquet"
    with TraceWriter(path, 1, 1) as writer:
        writer.append(rows)
    Manifest(cell, status="done").write(folder)
    return path


@pytest.fixture
def write_trace(make_cell):
    """A trace with these columns, in a folder, of a cell that differs so from the usual one."""
    return lambda folder, columns, **cell: _write_trace(folder, make_cell(**cell), columns)
