"""A trace of this project as a recording."""

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from harness.errors import SchemaError, UsageError
from harness.files.bounded import reading
from harness.files.parquet import require_room
from harness.record.cell import Cell
from harness.record.folder import MANIFEST
from harness.record.manifest import read_manifest
from harness.record.trace import FORMAT, FORMAT_KEY, term_names
from harness.reward.row_steps import FIELDS, TOUCHED
from harness.score.recording import COLUMNS, MOST_ROWS, ROWS, Recording, choose_columns
from harness.text import shortened

SHOWN = 60
"""The most characters of a name in a message."""


def open_trace(path: Path) -> Recording:
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
    columns = choose_columns(schema.names)
    if "distance" in columns and set(TOUCHED) <= set(schema.names):
        columns = (*columns, *TOUCHED)
    cell = _read_cell(path.with_name(MANIFEST))
    reward, seed = (cell.reward, cell.seed) if cell else (None, None)
    report = partial(_report_trace, path)
    fields = tuple(name for name, needed in FIELDS.items() if set(needed) <= set(schema.names))
    terms = term_names(path) if reward else ()
    return Recording(path, columns, reward, seed, partial(_trace_batches, path, columns), report, 1, fields, terms)


def _what_it_has(names: Sequence[str]) -> str:
    """What a Parquet file of others is, and what to do with it."""
    if {"episode_index", "frame_index"} <= set(names):
        return "it is a part of a LeRobot data set: harness audit lerobot:FOLDER"
    told = ", ".join(shortened(name, SHOWN) for name in names[:12]) + (", ..." if len(names) > 12 else "")
    return f"export its rewards as CSV with a column 'reward'; there is: {told}"


def _read_cell(manifest: Path) -> Cell | None:
    return read_manifest(manifest.parent).cell if manifest.is_file() else None


def _trace_batches(path: Path, columns: tuple[str, ...], fields: Sequence[str]) -> Iterator[pa.RecordBatch]:
    with reading(path, "trace"), pq.ParquetFile(path) as file:
        yield from file.iter_batches(batch_size=ROWS, columns=[*columns, *fields])


def _report_trace(path: Path, problem: str) -> UsageError:
    return UsageError(f"{path}: {problem}")
