"""The mean curves that the indices are read from, thinned to a small file."""

import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from harness.authoring.commands import Comparison, GroupCurve

CURVES = "curves.parquet"
ROWS = 1_200
"""The most rows per curve."""
FORMAT = 1
ABOUT = (
    "Mean accumulated reward of the runs trained with one reward, scored by another (the shaped reward), at every n-th "
    "step; n is the column 'every'. Of one curve the sum of its negative values times n is about I_N, that of its "
    "positive values I_P."
)
LABELS = ("simulator", "algorithm", "robot", "task", "trained_with", "scored_by", "seeds")
SCHEMA = pa.schema(
    [
        *(pa.field(name, pa.dictionary(pa.int32(), pa.string())) for name in LABELS),
        pa.field("training_steps", pa.int64()),
        pa.field("every", pa.int32()),
        pa.field("step", pa.int32()),
        pa.field("value", pa.float32()),  # the thinning leaves out more than the digits do
    ],
    metadata={"format": str(FORMAT), "about": ABOUT},
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
    table = pa.concat_tables([SCHEMA.empty_table(), *tables]).unify_dictionaries()
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
    return pa.Table.from_pydict({**same, "step": steps, "value": values.astype(np.float32)}, schema=SCHEMA)
