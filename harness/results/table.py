"""``results.parquet``: one row per cell, with what its policy did, and what random actions do."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import pyarrow as pa
import pyarrow.parquet as pq

from harness.files.sums import making
from harness.files.whole_file import whole_file
from harness.record.manifest import Manifest
from harness.record.store import RESULTS
from harness.results.measured import Measured

RANDOM = "random_"
"""What the columns of random actions begin with."""


class Numbers(NamedTuple):
    """The numbers of one cell."""

    values: Mapping[str, float | None]
    """By column."""
    reasons: Mapping[str, str] = {}
    """Why there is no number, by the name of what has none."""


Rows: TypeAlias = Iterable[tuple[Manifest, Numbers | None]]
"""Cells, each with its numbers; None of a cell that is not done."""


def metric_columns(metrics: Iterable[str]) -> list[str]:
    """The columns of metrics: those of the policy, then those of random actions."""
    names = list(metrics)
    return [*names, *(f"{RANDOM}{name}" for name in names)]


def numbers_of(measured: Measured, metrics: Iterable[str]) -> Numbers:
    """What metrics say of a cell, in the columns of `metric_columns`."""
    names = list(metrics)
    at_random = {f"{RANDOM}{name}": measured.random.get(name) for name in names}
    return Numbers({**{name: measured.own[name] for name in names}, **at_random}, measured.reasons)


def table_of(rows: Rows, columns: Iterable[str] = ()) -> pa.Table:
    """One row for each cell: what is known of it, why a number is missing, and its numbers.

    Args:
        rows: The cells.
        columns: Columns that come first among those of numbers, although no cell may have a number in them.
    """
    known = list(rows)
    table = pa.Table.from_pylist([_facts(manifest, numbers) for manifest, numbers in known])
    for name in dict.fromkeys([*columns, *(name for _, numbers in known if numbers for name in numbers.values)]):
        values = [numbers and numbers.values.get(name) for _, numbers in known]
        table = table.append_column(name, pa.array(values, pa.float64()))
    return table


def write_table(folder: Path, rows: Rows, columns: Iterable[str] = ()) -> Path:
    """Write the table of an experiment in place of an earlier one. A reader finds one of them, whole.

    Args:
        folder: The folder of the experiment.
        rows: See `table_of`.
        columns: See `table_of`.

    Raises:
        OSError: It cannot be written.
    """
    table, path = table_of(rows, columns), folder / RESULTS
    with making(path), whole_file(path) as partial:
        pq.write_table(table, partial)
    return path


def _facts(manifest: Manifest, numbers: Numbers | None) -> dict[str, Any]:
    return {
        **cell_to_json(manifest),
        "robot": manifest.cell.robot,
        "task": manifest.cell.task.label,
        "not_measured": "; ".join(f"{name}: {why}" for name, why in numbers.reasons.items()) if numbers else "",
    }


def cell_to_json(manifest: Manifest) -> dict[str, Any]:
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
