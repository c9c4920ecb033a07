"""``results.parquet``: one row per cell, every metric of its policy and of random actions."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, TypeAlias

import pyarrow as pa
import pyarrow.parquet as pq

from harness.files.sums import making
from harness.files.whole_file import whole_file
from harness.record.manifest import Manifest
from harness.record.store import RESULTS
from harness.results.measured import Measured

Row: TypeAlias = dict[str, Any]


def row_of(manifest: Manifest, measured: Measured | None, metrics: Iterable[str]) -> Row:
    """The row of a cell.

    Args:
        manifest: The manifest of the cell.
        measured: The values of the metrics; None if the cell is not done.
        metrics: The names of the metrics.
    """
    names = list(metrics)
    return {
        **cell_to_json(manifest),
        "robot": manifest.cell.robot,
        "task": manifest.cell.task.label,
        "not_measured": "; ".join(f"{name}: {why}" for name, why in measured.reasons.items()) if measured else "",
        **{name: measured and measured.own[name] for name in names},
        **{f"random_{name}": measured and measured.random.get(name) for name in names},
    }


def table_of(rows: Iterable[Row], metrics: Iterable[str]) -> pa.Table:
    """Rows as a table; see `row_of`.

    Args:
        rows: The rows of the cells.
        metrics: The names of all metrics.
    """
    names = list(metrics)
    table = pa.Table.from_pylist(list(rows))
    for name in (prefix + name for prefix in ("", "random_") for name in names):
        # a column without a value would have no type
        table = table.set_column(table.schema.get_field_index(name), name, table.column(name).cast(pa.float64()))
    return table


def write_table(folder: Path, rows: Iterable[Row], metrics: Iterable[str]) -> Path:
    """Write the table of an experiment in place of an earlier one. A reader finds one of them, whole.

    Args:
        folder: The folder of the experiment.
        rows: See `row_of`.
        metrics: The names of all metrics.

    Raises:
        OSError: It cannot be written.
    """
    table, path = table_of(rows, metrics), folder / RESULTS
    with making(path), whole_file(path) as partial:
        pq.write_table(table, partial)
    return path


def cell_to_json(manifest: Manifest) -> Row:
    """The facts about a cell as plain data."""
    cell = manifest.cell
    return {
        "id": cell.id,
        "simulator": cell.simulator.label,
        "algorithm": cell.algorithm.label,
        "reward": cell.reward.label,
        "seed": cell.seed,
        "status": manifest.status,
        "reason": manifest.reason,
        "seconds": manifest.seconds,
        "steps": cell.steps,
    }
