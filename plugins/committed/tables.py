"""The tables of a summary: a row per cell, the mean curves that indices are read from, the curves of single runs."""

import csv
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from io import StringIO
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from harness.authoring.commands import RANDOM, Comparison, GroupCurve, Manifest, curve_of, require_room, told_manifests
from harness.authoring.pages import FEWEST, POINTS, CurvePanel, Drawn, panels_of, plain_text
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


RUNS = "runs.parquet"
OF_ALL_RUNS = 8_000
"""The most points of all runs in a figure together, about 70 kB."""
PLACE = ("simulator", "algorithm", "robot", "task")
RUNS_ABOUT = (
    "The curve of each run under the reward that paid it, and the mean of the runs of a comparison, whose seeds are "
    "told: the points that the figures of accumulated reward draw."
)
RUNS_SCHEMA = pa.schema(
    [
        *(pa.field(name, pa.string()) for name in (*PLACE, "trained_with")),
        pa.field("training_steps", pa.int64()),
        pa.field("seeds", pa.string()),
        pa.field("step", pa.list_(pa.int32())),
        pa.field("value", pa.list_(pa.float32())),
    ],
    metadata={"format": str(FORMAT), "about": RUNS_ABOUT},
)

TEXTS = (*PLACE, "trained_with", "seeds")
MOST_CURVES, MOST_POINTS, LONGEST_TEXT = 1_000_000, 100_000_000, 100_000
"""Most that is read of a file, of its curves and of one text in it."""


class Key(NamedTuple):
    """What a curve is found by."""

    simulator: str
    algorithm: str
    robot: str
    task: str
    trained_with: str
    training_steps: int
    seeds: str
    """The seed of a run; of a mean all of them, a blank between two."""


Runs: TypeAlias = Mapping[Key, Drawn]


def write_runs(combinations: Iterable[Comparison]) -> bytes:
    """``runs.parquet``: the curves of every combination that has a finished pair, each curve once."""
    return runs_file_of({key: drawn for it in combinations for key, drawn in _curves(it)})


def runs_file_of(runs: Runs) -> bytes:
    """The bytes of a file with these curves."""
    rows = [
        {**key._asdict(), "step": drawn.steps.astype(np.int32), "value": drawn.values.astype(np.float32)}
        for key, drawn in runs.items()
    ]
    buffer = pa.BufferOutputStream()
    pq.write_table(pa.Table.from_pylist(rows, schema=RUNS_SCHEMA), buffer, compression="zstd")
    content: bytes = buffer.getvalue().to_pybytes()
    return content


def read_runs(content: bytes) -> Runs:
    """The curves of such a file.

    Raises:
        ValueError: They take more room than a summary may, or it is no such file.
    """
    file = pq.ParquetFile(pa.BufferReader(content), read_dictionary=TEXTS)
    if file.metadata.num_rows > MOST_CURVES:
        raise ValueError(f"it has {file.metadata.num_rows:,} curves, {MOST_CURVES:,} are allowed")
    require_room(file, most=MOST_POINTS)
    table = file.read()
    if any(len(text) > LONGEST_TEXT for name in TEXTS for text in table[name].unique().to_pylist()):
        raise ValueError(f"a text has more than {LONGEST_TEXT:,} characters")
    rows = table.to_pylist()
    return {
        Key(**{name: row[name] for name in Key._fields}): Drawn(
            np.asarray(row["step"], np.float64), np.asarray(row["value"], np.float64)
        )
        for row in rows
    }


def panels_in(
    runs: Runs, combination: Comparison, kind: Literal["accumulated", "per-step"]
) -> tuple[CurvePanel, CurvePanel] | None:
    """The panels of a combination; None where its curves are not there."""
    indices = combination.number.decomposition
    if indices is None:
        return None
    sides = (("Baseline", combination.baseline, indices.baseline), ("Proposed", combination.proposed, indices.proposed))
    panels = []
    for (role, reward, index), trained in zip(sides, combination.names, strict=True):
        keys = [_key(combination, trained, [seed]) for seed in combination.seeds]
        mean = runs.get(_key(combination, trained, combination.seeds))
        if mean is None or any(key not in runs for key in keys):
            return None
        drawn = tuple(runs[key] for key in keys)
        panels.append(CurvePanel(role, reward, kind, index, combination.seeds, drawn, mean))
    return panels[0], panels[1]


def _curves(combination: Comparison) -> Iterator[tuple[Key, Drawn]]:
    points = max(FEWEST, min(POINTS, OF_ALL_RUNS // (2 * max(1, len(combination.seeds)))))
    for panel, trained in zip(panels_of(combination, points) or (), combination.names, strict=False):
        for seed, run in zip(panel.seeds, panel.runs, strict=True):
            yield _key(combination, trained, [seed]), run
        yield _key(combination, trained, panel.seeds), panel.mean


def _key(combination: Comparison, trained: str, seeds: Sequence[int]) -> Key:
    labels, of_seeds = combination.group.labels, " ".join(map(str, seeds))
    simulator, algorithm, robot, task = (labels.get(kind, "") for kind in PLACE)
    return Key(simulator, algorithm, robot, task, trained, combination.group.steps, of_seeds)
