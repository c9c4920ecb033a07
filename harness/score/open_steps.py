"""Logs of steps by the names of their files: this project's traces, and CSV files of anybody."""

import glob
import os
from collections.abc import Iterable
from pathlib import Path

from harness.errors import SchemaError, UsageError
from harness.files.bounded import HEAD, kind_of, open_regular, reading
from harness.log import Log
from harness.log.open_log import formats_of, open_logs
from harness.registry.choice import Registry
from harness.registry.spec import nothing_at
from harness.score.csv_steps import MOST_BYTES, StepsCsv, open_csv, shown_names
from harness.score.row_meaning import NEEDED, RECORD

_PARQUET = b"PAR1"
_NOUNS = {"episode": "an episode", "point": "a point of a curve"}


def match_steps(patterns: str | Iterable[str], registry: Registry | None = None) -> list[Log]:
    """The logs of steps that a pattern, or any of several, matches: sorted, each once; ``**`` stands for any folders.

    Args:
        patterns: The names of files, or patterns of them.
        registry: See `open_steps`.

    Raises:
        UsageError: A pattern matches no file, or a file is no log of steps.
    """
    return [open_steps(path, registry) for path in matched_paths(patterns)]


def is_table_of_steps(path: Path) -> bool:
    """Whether a file is a trace, or a CSV file of steps, by its first bytes; no other format is asked."""
    if path.is_dir():
        return False
    with open_regular(path, MOST_BYTES) as file:
        head = file.read(HEAD)
    return head.startswith(_PARQUET) or StepsCsv().recognises(path, head)


def open_steps(path: Path, registry: Registry | None = None) -> Log:
    """A log of steps; its columns are looked at, its rows are read later.

    Args:
        path: A file.
        registry: Knows the formats of other logs, so that a file of episodes is called by its name.

    Raises:
        UsageError: The file cannot be read, is empty, something else by its first bytes, or has no reward column.
        SchemaError: It is a Parquet file, and no trace that this version reads.
    """
    with reading(path, "recording", UsageError):
        try:
            with open_regular(path, MOST_BYTES) as file:
                head = file.read(HEAD)
        except OSError as error:
            raise UsageError(f"{path} cannot be read: {error.strerror}") from error
        if not head:
            raise UsageError(f"{path} is empty")
        if head.startswith(_PARQUET):
            return _trace_of(path)
        if registry is not None and not StepsCsv().recognises(path, head):
            other = next((name for name, it in formats_of(registry).items() if it.recognises(path, head)), None)
            if other is not None:
                return _only_log(path, other, registry)
        if kind := kind_of(head, path):
            raise UsageError(f"{path} is {kind.sentence}")
        return open_csv(path)


def _trace_of(path: Path) -> Log:
    """The trace in a Parquet file.

    Raises:
        SchemaError: It is none.
        UsageError: It has no rows.
    """
    import pyarrow.parquet as pq  # most files are tables of others

    from harness.record.cell_log import cell_log
    from harness.record.trace import FORMAT_KEY

    with reading(path, "trace"):
        metadata = pq.read_metadata(path)
        schema = metadata.schema.to_arrow_schema()
    if FORMAT_KEY not in (schema.metadata or {}):
        told = f"export its rewards as CSV with a column 'reward'; there is: {shown_names(schema.names)}"
        if {"episode_index", "frame_index"} <= {*schema.names}:
            told = "it is a part of a LeRobot data set: harness audit lerobot:FOLDER"
        raise SchemaError(f"{path} is a Parquet file, and no trace: {told}")
    if not metadata.num_rows:
        raise UsageError(f"{path} has no rows")
    return cell_log(path)


def _only_log(path: Path, name: str, registry: Registry) -> Log:
    """The log of steps that a format reads.

    Raises:
        UsageError: Its rows are no steps, or it holds several trainings.
    """
    logs = open_logs(path, registry, name)
    facts = logs[0].facts
    if facts.unit != "step":
        raise UsageError(f"{path} is {facts.format}: a row is {_NOUNS[facts.unit]}, and {NEEDED}; {RECORD}")
    if len(logs) > 1:
        raise UsageError(f"{path} holds {len(logs)} trainings: give each run a file of its own")
    return logs[0]


def matched_paths(patterns: str | Iterable[str], *, folders: bool = False) -> list[Path]:
    """The files that a pattern, or any of several, matches: sorted, each once; ``**`` stands for any folders.

    Args:
        patterns: The names of files, or patterns of them.
        folders: Whether a pattern that matches no file may match folders.

    Raises:
        UsageError: A pattern matches nothing.
    """
    found = set[Path]()
    for pattern in [patterns] if isinstance(patterns, str) else patterns:
        path = Path(os.path.expanduser(pattern))  # no error, whatever the text
        is_name = os.path.isfile(path) or (folders and os.path.isdir(path))  # a name may hold [ or *
        matched = [path] if is_name else [Path(name) for name in glob.glob(str(path), recursive=True)]
        files = [it for it in matched if os.path.isfile(it)]
        if not files and not (folders and matched):
            if not matched and not glob.has_magic(pattern):
                raise UsageError(nothing_at(path))
            only = "; it matches folders only" if matched else ""
            raise UsageError(f"No file matches '{pattern}'{only}. Quote a pattern, as in 'runs/*.csv'")
        found.update(files or matched)
    return sorted(found)
