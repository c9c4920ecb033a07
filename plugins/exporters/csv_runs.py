"""The trainings of an experiment as CSV files."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv

from harness import Float
from harness.files.bounded import whole_file
from harness.log.log import ROWS
from harness.record import TRACE, read_recording, read_trace
from harness.record.folder import TRAINING_RECORDING
from harness.record.recording.facts import facts_of, file_column
from harness.record.recording.recorded_training import INTEGERS, TICK, TICK_IN_FILE, is_recording, recordings_in
from harness.record.trace import TERM
from harness.results import Group, Results
from harness.reward.steps import ENDS
from harness.score.csv_steps import EVENTS
from harness.text import file_stems


def write_runs(results: Results, out: Path) -> dict[Path, int]:
    """Write a file for each done cell into `out`, in one folder for each group and reward.

    ::

        mujoco-sac-fd100-fd100-reach/arp/seed-0.csv
        mujoco-sac-fd100-fd100-reach/baseline-control/seed-6.csv    the baseline trained again for the null control
        ppo-gymnasium-id-pendulum-v1/own/seed-0.csv                 in an environment

    Returns:
        How many files were written into each folder.

    Raises:
        SchemaError: A trace or a recording is damaged or written by a newer version.
        OSError: `out` cannot be written.
    """
    written: dict[Path, int] = {}
    for name, cells in zip(file_stems(map(_text, results.groups)), results.groups.values(), strict=True):
        paid = {cell: f"{cell.reward.label}{' control' * results.is_control(cell)}" for cell in cells}
        kinds = list(dict.fromkeys(paid.values()))
        folders = {kind: out / name / stem for kind, stem in zip(kinds, file_stems(kinds), strict=True)}
        for cell in cells:
            folder = folders[paid[cell]]
            folder.mkdir(parents=True, exist_ok=True)
            _write(results.store.cell_folder(cell), folder / f"seed-{cell.seed}.csv")
            written[folder] = written.get(folder, 0) + 1
    return written


def write_recordings(folder: Path, out: Path) -> dict[Path, int]:
    """Write a file for each recorded training in a folder that is no experiment's, under its own path.

    Returns:
        How many files were written into each folder.

    Raises:
        SchemaError: A recording is damaged or written by a newer version.
        OSError: `out` cannot be written.
    """
    written: dict[Path, int] = {}
    for path in sorted(recordings_in(folder)):
        place = out / path.relative_to(folder)
        target = place.with_name(f"{place.name}.csv") if path != folder else out / "recording.csv"
        target.parent.mkdir(parents=True, exist_ok=True)
        write_recording_csv(path, target)
        written[target.parent] = written.get(target.parent, 0) + 1
    return written


def _write(cell: Path, path: Path) -> None:
    if is_recording(cell / TRAINING_RECORDING):
        write_recording_csv(cell / TRAINING_RECORDING, path)
    else:
        write_csv(cell / TRACE, path)


def _text(group: Group) -> str:
    return " ".join(label.rsplit("/")[-1] if kind == "robot" else label for kind, label in group.labels.items())


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
    run = read_trace(trace)
    terms = [name for name in run.columns if name.startswith(TERM)]
    made = {**COLUMNS, **{name: _named(name) for name in terms}}
    schema = pa.schema([(name, pa.float64()) for name in made])
    header = pa.csv.WriteOptions(include_header=False)  # Arrow's own would stand in quotation marks
    with whole_file(path) as partial, partial.open("wb") as file:
        file.write(f"{','.join(made)}\n".encode())
        with pa.csv.CSVWriter(file, schema, write_options=header) as writer:
            for start in range(0, len(run), ROWS):
                rows = {name: run[name][start : start + ROWS] for name in (*READ, *terms)}
                writer.write_batch(pa.record_batch([column(rows) for column in made.values()], schema=schema))


def write_recording_csv(folder: Path, path: Path) -> None:
    """Write a recording to `path`, whole or not at all: one row for each step, in the order of time.

    The columns are ``time``, ``env``, ``episode``, ``step``, then ``reward_<name>`` and ``behaviour_<name>`` for every
    reward and measure, ``terminated`` and ``truncated``, and ``reward/<name>/<term>`` for each term of a reward. A
    number has as many digits as it takes to read it back exactly. Where a reward or a measure has no value, the field
    is empty.

    Args:
        folder: Of the recording.
        path: A CSV file, in a folder that is there.

    Raises:
        SchemaError: The recording is damaged or written by a newer version.
        OSError: `path` cannot be written.
    """
    log = read_recording(folder)
    facts = facts_of(log)
    names = (TICK, *INTEGERS, *facts.numbers, *ENDS, *facts.term_columns)
    rows = log.rows(names)
    columns = {
        TICK_IN_FILE if name == TICK else name if name in facts.term_columns else file_column(name): rows[name]
        for name in names
    }
    table = pa.table({name: pa.array(values, from_pandas=True) for name, values in columns.items()})
    with whole_file(path) as partial:
        pa.csv.write_csv(table, partial, pa.csv.WriteOptions(quoting_style="needed"))
