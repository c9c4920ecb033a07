"""A trace of this project as a log whose columns have the standard names."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from harness.errors import SchemaError, UsageError
from harness.files.bounded import reading
from harness.files.parquet import require_room
from harness.log import Log, LogFacts, in_memory
from harness.log.log import MOST_ROWS, ROWS, Array, Columns
from harness.record.folder import MANIFEST
from harness.record.manifest import read_manifest
from harness.record.row_steps import TOUCHED
from harness.record.trace import FIELDS, FORMAT, FORMAT_KEY, TERM, Trace, to_numpy
from harness.registry.choice import Choice
from harness.score.csv_steps import COLUMNS, PAY, choose_columns, is_finite, read_rows, standard_columns
from harness.text import shortened

SHOWN = 60
"""The most characters of a name in a message."""


@dataclass(frozen=True, kw_only=True)
class TraceFacts(LogFacts):
    """What is known of a trace beside its rows.

    Attributes:
        reward: The reward that paid it, if the manifest beside it says so.
    """

    reward: Choice | None = None


def paid_by(log: Log) -> Choice | None:
    """The reward that paid a log, with its parameters, if that is known."""
    return log.facts.reward if isinstance(log.facts, TraceFacts) else None


def log_of(trace: Trace) -> Log:
    """A trace that is in memory; it needs no column that its reader does not want."""
    fields = {name: values for name in FIELDS if (values := trace.field(name)) is not None}
    start = {"start": trace["step"] == 0}
    return in_memory(LogFacts(path=Path(), format="trace"), {**trace.columns, **start, **fields})


def open_trace(path: Path) -> Log:
    """A recorded run in a Parquet file. The manifest beside it, if there is one, names the reward that paid it.

    Raises:
        SchemaError: It is no trace that this version reads.
    """
    with reading(path, "trace"):
        with pq.ParquetFile(path) as file:
            schema, rows = file.schema_arrow, file.metadata.num_rows
            if rows <= MOST_ROWS:
                require_room(file, [name for name in (*COLUMNS, *TOUCHED) if name in schema.names])
        version = int((schema.metadata or {}).get(FORMAT_KEY, b"0"))
    if FORMAT_KEY not in (schema.metadata or {}):
        raise SchemaError(f"{path} is a Parquet file, and no trace: {_what_it_has(schema.names)}")
    if rows > MOST_ROWS:
        raise SchemaError(f"{path} has {rows:,} rows, {MOST_ROWS:,} are allowed")
    if not 0 < version <= FORMAT:
        raise SchemaError(f"{path} is a trace of format {version}, this version reads 1 to {FORMAT}")
    there = set(schema.names)
    chosen = choose_columns(there)
    has_flags = "distance" in chosen and set(TOUCHED) <= there
    own = {
        **{name: (name,) for name in TOUCHED if has_flags},
        **{name: needed for name, needed in FIELDS.items() if set(needed) <= there},
        **{f"{PAY}/{name.removeprefix(TERM)}": (name,) for name in schema.names if name.startswith(TERM)},
    }
    facts = TraceFacts(path=path, format=f"trace of format {version}")
    if (manifest := path.with_name(MANIFEST)).is_file():
        cell = read_manifest(manifest.parent).cell
        facts = TraceFacts(
            path=path, format=facts.format, trained_with=cell.reward.label, seed=cell.seed, reward=cell.reward
        )
    return Log(facts, (*standard_columns(chosen), *own), partial(_read, path, chosen, own))


def _what_it_has(names: Sequence[str]) -> str:
    """What a Parquet file of others is, and what to do with it."""
    if {"episode_index", "frame_index"} <= set(names):
        return "it is a part of a LeRobot data set: harness audit lerobot:FOLDER"
    told = ", ".join(shortened(name, SHOWN) for name in names[:12]) + (", ..." if len(names) > 12 else "")
    return f"export its rewards as CSV with a column 'reward'; there is: {told}"


def _read(
    path: Path, chosen: Sequence[str], own: Mapping[str, Sequence[str]], names: tuple[str, ...]
) -> Iterator[Columns]:
    """See `harness.log.Log.read`."""
    wanted = {name: own[name] for name in names if name in own}
    read = dict.fromkeys([*chosen, *(column for columns in wanted.values() for column in columns)])
    rows = counted = 0
    with reading(path, "trace"), pq.ParquetFile(path) as file:
        for batch in file.iter_batches(batch_size=ROWS, columns=list(read)):
            table = pa.Table.from_batches([batch])
            columns = {name: table.column(name).to_numpy().astype(np.float64, copy=False) for name in chosen}
            made, more = read_rows(columns, counted), {name: _stacked(table, of) for name, of in wanted.items()}
            if made is None or not is_finite(more.values()):
                raise UsageError(f"{path}: a number is missing, not finite or too large")
            rows += batch.num_rows
            counted = int(made["step"][-1]) if "step" in made else 0
            found = {**made, **more}
            yield {name: found[name] for name in names}
    if not rows:
        raise UsageError(f"{path} has no rows")


def _stacked(table: pa.Table, columns: Sequence[str]) -> Array:
    """A field of some rows, (rows, ...)."""
    values = [to_numpy(table.column(column), column) for column in columns]
    return values[0] if len(values) == 1 else np.stack(values, axis=1)
