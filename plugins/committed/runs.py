"""The curves of single runs as the figures of accumulated reward show them, so that these can be drawn again."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from harness.authoring.commands import Comparison, require_room
from harness.authoring.pages import FEWEST, POINTS, CurvePanel, Drawn, panels_of

RUNS = "runs.parquet"
FORMAT = 1
OF_ALL_RUNS = 8_000
"""The most points of all runs in a figure together, about 70 kB."""
PLACE = ("simulator", "algorithm", "robot", "task")
ABOUT = (
    "The curve of each run under the reward that paid it, and the mean of the runs of a comparison, whose seeds are "
    "told: the points that the figures of accumulated reward draw."
)
SCHEMA = pa.schema(
    [
        *(pa.field(name, pa.string()) for name in (*PLACE, "trained_with")),
        pa.field("training_steps", pa.int64()),
        pa.field("seeds", pa.string()),
        pa.field("step", pa.list_(pa.int32())),
        pa.field("value", pa.list_(pa.float32())),
    ],
    metadata={"format": str(FORMAT), "about": ABOUT},
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
    pq.write_table(pa.Table.from_pylist(rows, schema=SCHEMA), buffer, compression="zstd")
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
    baseline, proposed = combination.baseline_index, combination.proposed_index
    if baseline is None or proposed is None:
        return None
    sides = (("Baseline", combination.baseline, baseline), ("Proposed", combination.proposed, proposed))
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
