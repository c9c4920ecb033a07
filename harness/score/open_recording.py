"""Recorded runs by the names of their files: this project's traces, and CSV files of anybody."""

from collections.abc import Iterable
from pathlib import Path

from harness.errors import UsageError
from harness.files.bounded import open_regular, reading
from harness.files.file_kind import HEAD, kind_of
from harness.files.matched import matched_paths
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
    return [open_recording(path) for path in matched_paths(patterns)]


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
