"""The tables of a summary: a row per cell, and the mean curves that indices are read from."""

import csv
import math
from collections.abc import Iterable, Iterator
from io import StringIO
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from harness.eta import GroupCurve, curve_of
from harness.record import Manifest
from harness.report.page.answer import plain_text
from harness.results import Comparison, Results
from harness.results.results import told_manifests
from harness.results.table import RANDOM

OWN = ("first_negative", "crossover", "I_N", "I_P", "final_accumulated_reward")
"""Columns on the single run, under the reward that paid it. The indices are not rounded."""
NOT_MEASURED = "not_measured"
"""The column of the metrics that failed, each with the reason."""


def write_cells(results: Results) -> str:
    """``cells.csv``: the cells in the order of the plan, then every metric of the final evaluation; empty if unknown.

    Numbers have as many digits as it takes to read them back exactly.

    Raises:
        SchemaError: A trace is damaged or written by a newer version.
    """
    rows = [_row(results, manifest) for manifest in told_manifests(results)]
    measured = dict.fromkeys([*results.metrics, *(name for row in rows for name in row if name not in KNOWN)])
    text = StringIO()
    writer = csv.DictWriter(text, [*_describe_names(), *OWN, *measured, NOT_MEASURED], lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: plain_text(value) for name, value in row.items()} for row in rows)
    return text.getvalue()


def _row(results: Results, manifest: Manifest) -> dict[str, Any]:
    row = dict(zip(_describe_names(), _describe(manifest), strict=True))
    if manifest.status != "done":
        return row
    numbers = results.numbers(manifest.cell)
    values = {name: value for name, value in numbers.values.items() if not name.startswith(RANDOM)}
    failed = "; ".join(f"{name}: {why}" for name, why in numbers.reasons.items())
    return {**row, **_own(results, manifest), **values, NOT_MEASURED: failed}


def _describe_names() -> tuple[str, ...]:
    places = ("id", "simulator", "task", "robot", "algorithm", "reward", "seed", "steps")
    return (*places, "status", "reason", "training_seconds", "seconds")


def _describe(manifest: Manifest) -> tuple[Any, ...]:
    cell = manifest.cell
    choices = (cell.simulator.label, cell.task.label, cell.robot, cell.algorithm.label, cell.reward.label)
    times = (manifest.training_seconds or None, manifest.seconds or None)  # 0: the process could not measure it
    return (cell.id, *choices, cell.seed, cell.steps, manifest.status, " ".join(manifest.reason.split()), *times)


def _own(results: Results, manifest: Manifest) -> dict[str, Any]:
    reward = results.recorded(manifest.cell)
    index = curve_of([reward]).index
    final = float(np.cumsum(reward)[-1]) if len(reward) else None
    sums = (index.negative_sum, index.positive_sum)
    return dict(zip(OWN, (index.first_negative, index.crossover, *sums, final), strict=True))


KNOWN = {*_describe_names(), *OWN, NOT_MEASURED}
"""Columns that every cell has."""


CURVES = "curves.parquet"
ROWS = 1_200
"""The most rows per curve."""
FORMAT = 1
CURVES_ABOUT = (
    "Mean accumulated reward of the runs trained with one reward, scored by another (the shaped reward), at every n-th "
    "step; n is the column 'every'. Of one curve the sum of its negative values times n is about I_N, that of its "
    "positive values I_P."
)
LABELS = ("simulator", "algorithm", "robot", "task", "trained_with", "scored_by", "seeds")
CURVES_SCHEMA = pa.schema(
    [
        *(pa.field(name, pa.dictionary(pa.int32(), pa.string())) for name in LABELS),
        pa.field("training_steps", pa.int64()),
        pa.field("every", pa.int32()),
        pa.field("step", pa.int32()),
        pa.field("value", pa.float32()),  # the thinning leaves out more than the digits do
    ],
    metadata={"format": str(FORMAT), "about": CURVES_ABOUT},
)


def write_curves(combinations: Iterable[Comparison]) -> bytes:
    """``curves.parquet``: every S_r(tau_q) of every combination, each curve once.

    A curve is named by its labels and its seeds: rewards that are compared with one baseline over the same seeds share
    the baseline's curve.
    """
    named = {
        tuple(labels.items()): curve
        for combination in combinations
        for labels, curve in _label(combination)
        if curve.runs.shape[1]
    }
    tables = [_table(dict(labels), curve) for labels, curve in named.items()]
    table = pa.concat_tables([CURVES_SCHEMA.empty_table(), *tables]).unify_dictionaries()
    buffer = pa.BufferOutputStream()
    pq.write_table(table, buffer, compression="zstd")
    content: bytes = buffer.getvalue().to_pybytes()
    return content


def thin(curve: GroupCurve) -> tuple[np.ndarray, np.ndarray, int]:
    """Steps and values of the mean curve, at most ROWS of them, and how many steps lie between two."""
    skip = math.ceil(curve.runs.shape[1] / ROWS)
    values = curve.runs[:, ::skip].mean(axis=0)
    every = skip * curve.stride
    return np.arange(len(values)) * every, values, every


def _label(combination: Comparison) -> Iterator[tuple[dict[str, Any], GroupCurve]]:
    group, seeds = combination.group, " ".join(map(str, combination.seeds))
    scorers = {"baseline": combination.baseline, "proposed": combination.proposed}
    trained = combination.names._asdict()
    for (scorer, taught), curve in combination.curves.items():
        labels = group.labels
        places = (labels.get(kind, "") for kind in ("simulator", "algorithm", "robot", "task"))
        values = (*places, trained[taught], scorers[scorer], seeds)
        yield {**dict(zip(LABELS, values, strict=True)), "training_steps": group.steps}, curve


def _table(labels: dict[str, Any], curve: GroupCurve) -> pa.Table:
    steps, values, every = thin(curve)
    same = {name: [value] * len(steps) for name, value in {**labels, "every": every}.items()}
    return pa.Table.from_pydict({**same, "step": steps, "value": values.astype(np.float32)}, schema=CURVES_SCHEMA)
