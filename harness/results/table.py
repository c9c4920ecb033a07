"""``results.parquet``, a row for each cell: what its policy did, what random actions do; a table of comparisons."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import pyarrow as pa
import pyarrow.parquet as pq

from harness.files.bounded import making, whole_file
from harness.record.cell import Manifest
from harness.record.store import RESULTS
from harness.results.comparison import Comparison

RANDOM = "random_"
"""What the columns of random actions begin with."""


class Numbers(NamedTuple):
    """The numbers of one cell."""

    values: Mapping[str, float | None]
    """By column."""
    reasons: Mapping[str, str] = {}
    """Why there is no number, by the name of what has none."""


Rows: TypeAlias = Sequence[tuple[Manifest, Numbers | None]]
"""Cells, each with its numbers; None of a cell that is not done."""


def metric_columns(metrics: Iterable[str]) -> list[str]:
    """The columns of metrics: those of the policy, then those of random actions."""
    names = list(metrics)
    return [*names, *(f"{RANDOM}{name}" for name in names)]


def table_of(rows: Rows, columns: Iterable[str] = ()) -> pa.Table:
    """One row for each cell: what is known of it, why a number is missing, and its numbers.

    Args:
        rows: The cells.
        columns: Columns that come first among those of numbers, although no cell may have a number in them.
    """
    facts = [
        {
            **cell_to_json(manifest),
            "robot": manifest.cell.robot,
            "task": manifest.cell.task.label,
            "not_measured": "; ".join(f"{name}: {why}" for name, why in numbers.reasons.items()) if numbers else "",
        }
        for manifest, numbers in rows
    ]
    table = pa.Table.from_pylist(facts)
    for name in dict.fromkeys([*columns, *(name for _, numbers in rows if numbers for name in numbers.values)]):
        values = [numbers and numbers.values.get(name) for _, numbers in rows]
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


_RATIOS = ("eta_N", "eta_P", "ruler", "behaviour")
_NUMBERS = ("p", "p_corrected", "baseline_value", "proposed_value", "difference", "low", "high")
_TEXTS = ("simulator", "algorithm", "robot", "task", "baseline", "proposed", "answer", "decided_by", "measure")
SCHEMA = pa.schema(
    {
        **dict.fromkeys(_TEXTS, pa.string()),
        **dict.fromkeys(("steps", "seeds", "baseline_trainings", "proposed_trainings"), pa.int64()),
        **dict.fromkeys(_NUMBERS, pa.float64()),
        **{f"{name}{end}": pa.float64() for name in _RATIOS for end in ("", "_low", "_high")},
    }
)
"""The columns: where both rewards trained, the answer with its test, the measure that decides, the numbers."""


def comparison_rows(comparisons: Sequence[Comparison]) -> pa.Table:
    """A row for each comparison; null where a number is not known.

    ``seeds`` are those that both rewards have; behaviour is compared over all trainings of each.
    ``measure`` is the first of the measures that decide, with both values, their difference and its 95 % interval.
    ``ruler`` and ``behaviour`` are the parts of ``eta`` of the mean return where there is one, else those of eta_P.
    """
    return pa.Table.from_pylist(list(map(_row, comparisons)), SCHEMA)


def _row(comparison: Comparison) -> dict[str, Any]:
    number, ruling, change = comparison.number, comparison.answer.ruling, comparison.decisive
    headline = comparison.headline
    trainings = zip(("baseline_trainings", "proposed_trainings"), comparison.counts, strict=True)
    row = {**comparison.group.labels, **comparison.names._asdict(), **dict(trainings)}
    row |= {
        "steps": comparison.group.steps,
        "seeds": len(comparison.seeds),
        "answer": headline.answer.value,
        "decided_by": headline.decided_by,
    }
    if ruling is not None:
        row |= {"p": ruling.p, "p_corrected": ruling.corrected}
    if change is not None:
        row |= {"measure": change.name, "baseline_value": change.baseline, "proposed_value": change.proposed}
        row |= {"difference": change.difference, "low": change.low, "high": change.high}
    split = number.splits["eta_P"] if number.main is None else number.main.ratio
    for name, ratio in zip(_RATIOS, (number.eta_n, number.eta_p, split.ruler, split.behaviour), strict=True):
        row |= {name: ratio.value, f"{name}_low": ratio.low, f"{name}_high": ratio.high}
    return row
