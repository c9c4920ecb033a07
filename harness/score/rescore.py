"""Pays recorded runs again: a column of rewards per reward, in a file of its own beside the recording."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from harness.arrays import Float, Mask
from harness.errors import UsageError, one_line
from harness.files.bounded import reading, require_regular
from harness.files.parquet import require_room
from harness.files.sums import changed_since_made, note_made
from harness.files.whole_file import whole_file
from harness.record.folder import MANIFEST
from harness.reward import Reward
from harness.score.recording import Chunk, Recording
from harness.score.scorer import Scorer

MOST_BYTES = 2**35
"""Most that is read of a file of scores."""


class RecordingScorer:
    """Scores a recording chunk by chunk. Envs that trained together are runs of their own."""

    def __init__(self, reward: Reward) -> None:
        self._reward = reward
        self._scorers: dict[int, Scorer] = {}

    def score(self, chunk: Chunk) -> Float:
        """Shaped reward of the chunk's rows, (rows,)."""
        env = np.zeros(len(chunk.reward), np.int64) if chunk.env is None else chunk.env
        values = np.empty(len(env))
        for number in np.unique(env):
            scorer = self._scorers.setdefault(int(number), Scorer(self._reward))
            mine = env == number
            values[mine] = scorer.score(_rows_of(chunk, mine))
        return values


def rescore(recording: Recording, rewards: Mapping[str, Reward], into: Path) -> dict[str, str]:
    """Write what each of `rewards` would have paid, a column each named by its label, a row per recorded row.

    Columns of other rewards that `into` holds already are kept. The recording is not touched. A reward that raises
    costs its own column.

    Returns:
        By the label of each reward that raised, what it raised.

    Raises:
        UsageError: The recording has no distances, `into` belongs to another recording or cannot be written.
    """
    if not recording.has_distances:
        raise UsageError(f"{recording.path} records no distances: no other reward can be computed from it")
    scorers = {label: RecordingScorer(reward) for label, reward in rewards.items()}
    parts: dict[str, list[Float]] = {label: [] for label in rewards}
    failed: dict[str, str] = {}
    for chunk in recording.chunks():
        for label, scorer in scorers.items():
            try:
                if label not in failed:
                    parts[label].append(scorer.score(chunk))
            except (Exception, SystemExit) as error:  # a plugin may raise anything
                failed[label] = one_line(error)
    columns = {label: np.concatenate(values) for label, values in parts.items() if label not in failed}
    if columns:
        _write(into, columns)
    return failed


def _write(into: Path, columns: Mapping[str, Float]) -> None:
    kept: dict[str, pa.ChunkedArray] = {}
    rows = len(next(iter(columns.values())))
    if into.exists() and into.name not in changed_since_made(into.parent):
        with reading(into, "file of scores", UsageError):
            kept = _earlier(into, rows)
    try:
        into.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(into) as partial:
            pq.write_table(pa.table({**kept, **columns}), partial, compression="zstd")
        if (into.parent / MANIFEST).exists():
            note_made(into)  # behind the manifest, which names what the cell itself left
    except OSError as error:
        raise UsageError(f"'{into}' cannot be written: {error.strerror}. Name another folder with --out") from None


def _earlier(path: Path, rows: int) -> dict[str, pa.ChunkedArray]:
    require_regular(path, MOST_BYTES)
    file = pq.ParquetFile(path)
    if file.metadata.num_rows != rows:
        raise UsageError(f"{path} has {file.metadata.num_rows} rows, the recording {rows}: it belongs to another one")
    require_room(file)
    table = file.read()
    return dict(zip(table.column_names, table.columns, strict=True))


class _Rows(NamedTuple):
    """A chunk's rows of one env, as `harness.score.scorer.Rows`."""

    start: Mask
    begin_distance: Float
    previous_best: Float
    distance: Float
    touched: Mask | None


def _rows_of(chunk: Chunk, mask: Mask) -> _Rows:
    columns = (chunk.start, chunk.begin_distance, chunk.previous_best, chunk.distance, chunk.touched)
    rows = _Rows(*columns)  # type: ignore[arg-type]  # a recording with distances has the first four
    return rows if mask.all() else _Rows._make(None if column is None else column[mask] for column in rows)
