"""A trace of this project as a log of somebody's, with what the manifest beside it says."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet as pq

from harness.errors import SchemaError, UsageError
from harness.files.bounded import reading
from harness.log import Log
from harness.record.cell import Cell
from harness.record.folder import MANIFEST
from harness.record.manifest import read_manifest
from harness.record.trace import FORMAT_KEY, read_trace
from harness.registry.choice import Choice
from harness.text import shortened

SHOWN = 60
"""The most characters of a name in a message."""


def open_trace(path: Path) -> Log:
    """A recorded run in a Parquet file; its rows are read later.

    The manifest beside it, if there is one, names the reward that paid it, and its seed.

    Raises:
        SchemaError: It is no trace that this version reads.
        UsageError: It has no rows.
    """
    with reading(path, "trace"):
        metadata = pq.read_metadata(path)
        schema = metadata.schema.to_arrow_schema()
    if FORMAT_KEY not in (schema.metadata or {}):
        raise SchemaError(f"{path} is a Parquet file, and no trace: {_what_it_has(schema.names)}")
    if not metadata.num_rows:
        raise UsageError(f"{path} has no rows")
    trace = read_trace(path)
    if cell := _cell_of(path):
        return replace(trace, facts=replace(trace.facts, trained_with=cell.reward.label, seed=cell.seed))
    return trace


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
