"""One row per cell: what it was, how it ended, its own indices and its behaviour."""

import csv
from io import StringIO
from typing import Any

import numpy as np

from harness.authoring.commands import RANDOM, Manifest, curve_of, told_manifests
from harness.authoring.pages import plain_text
from harness.results import Results

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
