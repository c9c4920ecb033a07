"""A trace as a CSV file in the experimenters' columns, as `harness.score.csv_steps` reads them."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv

from harness.arrays import Float
from harness.files.whole_file import whole_file
from harness.log.log import ROWS
from harness.record.trace import TERM, read_trace, term_names
from harness.score.csv_steps import EVENTS

Columns = Mapping[str, Float]


def _named(name: str, sign: float = 1.0) -> Callable[[Columns], Float]:
    return lambda columns: sign * columns[name] + 0.0  # no -0.0


COLUMNS: Mapping[str, Callable[[Columns], Float]] = {
    "t": _named("step"),
    "beginDistance": _named("begin_distance"),
    "prevBest": lambda columns: np.minimum(columns["previous_best"], columns["distance"]),
    "distance": _named("distance"),
    "delta_distance": _named("delta_distance"),
    "reward": _named("reward"),
    "target x": _named("target_y", -1.0),
    "target y": _named("target_z"),
    "target z": _named("target_x"),
    "endEff x": _named("end_effector_y", -1.0),
    "endEff y": _named("end_effector_z"),
    "endEff z": _named("end_effector_x"),
    "previous_best": _named("previous_best"),
    **{name: _named(name) for name in EVENTS},
    "env": _named("env"),
}
"""The experimenters' own, as their second program means them: prevBest is the value after the step, and positions are
in Unity's frame, y up. Then what theirs lack: this project's best distance before the step, which is exact, what events
paid, and which of the envs that trained together."""
READ = (
    *("env", "step", "begin_distance", "previous_best", "distance", "delta_distance", "reward", *EVENTS),
    *(f"{point}_{axis}" for point in ("target", "end_effector") for axis in "xyz"),
)
"""The columns of a trace that are read."""


def write_csv(trace: Path, path: Path) -> None:
    """Write a trace to `path`, whole or not at all; a number has as many digits as it takes to read it back exactly.

    What each term of the reward paid stands behind the other columns, as ``reward/TERM``.

    Args:
        trace: A ``trace.parquet``.
        path: A CSV file, in a folder that is there.

    Raises:
        SchemaError: The trace is damaged or written by a newer version.
        OSError: `path` cannot be written.
    """
    terms = [f"{TERM}{name}" for name in term_names(trace)]
    run = read_trace(trace, [*READ, *terms])
    made = {**COLUMNS, **{name: _named(name) for name in terms}}
    schema = pa.schema([(name, pa.float64()) for name in made])
    header = pa.csv.WriteOptions(include_header=False)  # Arrow's own would stand in quotation marks
    with whole_file(path) as partial, partial.open("wb") as file:
        file.write(f"{','.join(made)}\n".encode())
        with pa.csv.CSVWriter(file, schema, write_options=header) as writer:
            for start in range(0, len(run), ROWS):
                rows = {name: run[name][start : start + ROWS] for name in (*READ, *terms)}
                writer.write_batch(pa.record_batch([column(rows) for column in made.values()], schema=schema))
