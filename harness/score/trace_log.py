"""A trace of this project as a log, and what paid it."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from harness.errors import SchemaError, UsageError
from harness.files.bounded import reading
from harness.files.parquet import require_room
from harness.log import Log, LogFacts, in_memory
from harness.log.log import MOST_ROWS, ROWS, Columns
from harness.record.cell import Cell
from harness.record.folder import MANIFEST
from harness.record.manifest import read_manifest
from harness.record.trace import FORMAT, FORMAT_KEY, KNOWN, SCALARS, TERM, Trace, to_numpy
from harness.registry.choice import Choice
from harness.text import shortened

SHOWN = 60
"""The most characters of a name in a message."""


def log_of(trace: Trace) -> Log:
    """A trace that is in memory."""
    return in_memory(LogFacts(path=Path("trace"), format="trace"), trace.columns)


def open_trace(path: Path) -> Log:
    """A recorded run in a Parquet file; its rows are read later.

    The manifest beside it, if there is one, names the reward that paid it, and its seed.

    Raises:
        SchemaError: It is no trace that this version reads.
        UsageError: It has no rows.
    """
    with reading(path, "trace"):
        with pq.ParquetFile(path) as file:
            schema, rows = file.schema_arrow, file.metadata.num_rows
            columns = tuple(name for name in schema.names if name in KNOWN.names or name.startswith(TERM))
            if rows <= MOST_ROWS:
                require_room(file, list(columns))
        version = int((schema.metadata or {}).get(FORMAT_KEY, b"0"))
    if FORMAT_KEY not in (schema.metadata or {}):
        raise SchemaError(f"{path} is a Parquet file, and no trace: {_what_it_has(schema.names)}")
    if rows > MOST_ROWS:
        raise SchemaError(f"{path} has {rows:,} rows, {MOST_ROWS:,} are allowed")
    if not 0 < version <= FORMAT:
        raise SchemaError(f"{path} is a trace of format {version}, this version reads 1 to {FORMAT}")
    for field in (schema.field(name) for name in columns if name in SCALARS):
        if field.type != KNOWN.field(field.name).type:
            raise SchemaError(
                f"{path} has a column {field.name} of {field.type}, not of {KNOWN.field(field.name).type}"
            )
    if not rows:
        raise UsageError(f"{path} has no rows")
    facts = LogFacts(path=path, format=f"trace of format {version}")
    if cell := _cell_of(path):
        facts = replace(facts, trained_with=cell.reward.label, seed=cell.seed)
    return Log(facts, columns, partial(_tables, path))


def paid_by(log: Log) -> Choice | None:
    """The reward that paid a trace, with all its parameters, if the manifest beside it says so."""
    cell = _cell_of(log.facts.path)
    return cell.reward if cell else None


def _cell_of(path: Path) -> Cell | None:
    return read_manifest(path.parent).cell if path.with_name(MANIFEST).is_file() else None


def _what_it_has(names: Sequence[str]) -> str:
    """What a Parquet file of others is, and what to do with it."""
    if {"episode_index", "frame_index"} <= set(names):
        return "it is a part of a LeRobot data set: harness audit lerobot:FOLDER"
    told = ", ".join(shortened(name, SHOWN) for name in names[:12]) + (", ..." if len(names) > 12 else "")
    return f"export its rewards as CSV with a column 'reward'; there is: {told}"


def _tables(path: Path, names: Sequence[str]) -> Iterator[Columns]:
    with reading(path, "trace"), pq.ParquetFile(path) as file:
        for batch in file.iter_batches(ROWS, columns=list(names)):
            table = pa.Table.from_batches([batch])
            yield {name: to_numpy(table.column(name), f"{path}: {name}") for name in names}
