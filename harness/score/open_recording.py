"""Recorded runs by the names of their files: this project's traces, and CSV files of anybody."""

import glob
from collections.abc import Iterable
from pathlib import Path

from harness.errors import UsageError
from harness.score.csv_recording import open_csv
from harness.score.recording import Recording
from harness.score.trace_recording import open_trace

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
        UsageError: The file cannot be read, is empty or has no reward column.
        SchemaError: It is a Parquet file, and no trace that this version reads.
    """
    try:
        with path.open("rb") as file:
            magic = file.read(len(_PARQUET))
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror}") from error
    if not magic:
        raise UsageError(f"{path} is empty")
    return open_trace(path) if magic == _PARQUET else open_csv(path)


def _match_files(pattern: str) -> list[Path]:
    path = Path(pattern).expanduser()
    if path.is_file():  # a name may hold [ or *
        return [path]
    matched = [Path(name) for name in glob.glob(str(path), recursive=True)]
    files = [name for name in matched if name.is_file()]
    if not files:
        only = "; it matches folders only" if matched else ""
        raise UsageError(f"No file matches '{pattern}'{only}. Quote a pattern, as in 'runs/*.csv'")
    return files
