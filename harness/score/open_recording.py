"""Recorded runs by the names of their files: this project's traces, and CSV files of anybody."""

import glob
import os
from collections.abc import Iterable
from pathlib import Path

from harness.errors import UsageError
from harness.files.bounded import open_regular, reading
from harness.files.file_kind import HEAD, kind_of
from harness.score.csv_recording import open_csv
from harness.score.recording import Recording
from harness.score.trace_recording import open_trace

MOST_BYTES = 8 * 2**30
"""The most bytes of a file: `harness.score.recording.MOST_ROWS` of 160 bytes each; they are read a piece at a time."""
_PARQUET = b"PAR1"


def match_recordings(patterns: str | Iterable[str]) -> list[Recording]:
    """The recordings that a pattern, or any of several, matches: sorted, each once; ``**`` stands for any folders.

    Raises:
        UsageError: A pattern matches no file, or a file is no recording.
    """
    given = [patterns] if isinstance(patterns, str) else list(patterns)
    files = {path for pattern in given for path in _match_files(pattern)}
    return [open_recording(path) for path in sorted(files)]


def open_recording(path: Path) -> Recording:
    """A recorded run; its columns are looked at, its rows are read later.

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
            return open_trace(path)
        kind = kind_of(head, path)
        if kind is not None:
            raise UsageError(f"{path} is {kind.sentence}")
        return open_csv(path)


def _match_files(pattern: str) -> list[Path]:
    path = Path(os.path.expanduser(pattern))  # no error, whatever the text
    if os.path.isfile(path):  # a name may hold [ or *
        return [path]
    matched = [Path(name) for name in glob.glob(str(path), recursive=True)]
    files = [name for name in matched if os.path.isfile(name)]
    if not files:
        only = "; it matches folders only" if matched else ""
        raise UsageError(f"No file matches '{pattern}'{only}. Quote a pattern, as in 'runs/*.csv'")
    return files
