"""Pays recorded runs again: a column of rewards per reward, in a file of its own beside the recording."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from harness.arrays import Float
from harness.errors import UsageError, one_line
from harness.files.bounded import reading, require_regular
from harness.files.parquet import require_room
from harness.files.sums import changed_since_made, note_made
from harness.files.whole_file import whole_file
from harness.record.folder import MANIFEST
from harness.record.row_steps import Rows
from harness.reward import Paid, Reward
from harness.reward.needs import needs_of
from harness.score.recording import Chunk, Recording
from harness.score.scorer import Scorer, fields_beside_distances

MOST_BYTES = 2**35
"""Most that is read of a file of scores."""


class RecordingScorer:
    """Scores a recording chunk by chunk. Envs that trained together are runs of their own.

    Attributes:
        fields: What chunks have to have beside distances, see `harness.score.recording.Recording.chunks`.
    """

    def __init__(self, reward: Reward) -> None:
        self._reward = reward
        self._scorers: dict[int, Scorer] = {}
        self.fields = fields_beside_distances(needs_of(reward).fields)

    def pay(self, chunk: Chunk) -> Paid:
        """Shaped reward of the chunk's rows and its terms, (rows,)."""
        env = np.zeros(len(chunk.reward), np.int64) if chunk.env is None else chunk.env
        rows, total, terms = _rows_of(chunk), np.empty(len(env)), dict[str, Float]()
        for number in np.unique(env):
            scorer = self._scorers.setdefault(int(number), Scorer(self._reward))
            mine = env == number
            part = scorer.pay(rows if mine.all() else rows.part(mine))
            total[mine] = part.total
            for name, values in part.terms.items():
                terms.setdefault(name, np.zeros(len(env)))[mine] = values
        return Paid(total, terms)


def rescore(recording: Recording, rewards: Mapping[str, Reward], into: Path) -> dict[str, str]:
    """Write what each of `rewards` would have paid, a column each named by its label, a row per recorded row.

    A term of a reward has a column ``LABEL/TERM`` behind it. Columns of other rewards that `into` holds already are
    kept. The recording is not touched. A reward that raises costs its own columns.

    Returns:
        By the label of each reward that raised, what it raised.

    Raises:
        UsageError: The recording has no distances, `into` belongs to another recording or cannot be written.
    """
    if not recording.has_distances:
        raise UsageError(f"{recording.path} records no distances: no other reward can be computed from it")
    failed: dict[str, str] = {}
    scorers: dict[str, RecordingScorer] = {}
    for label, reward in rewards.items():
        with _noted(label, failed):
            scorers[label] = RecordingScorer(reward)
    parts: dict[str, list[Paid]] = {label: [] for label in rewards}
    for chunk in recording.chunks(fields={field for it in scorers.values() for field in it.fields}):
        for label, scorer in scorers.items():
            if label not in failed:
                with _noted(label, failed):
                    parts[label].append(scorer.pay(chunk))
    columns = {
        name: values
        for label, paid in parts.items()
        if label not in failed
        for name, values in _columns_of(label, paid)
    }
    if columns:
        _write(into, columns)
    return failed


@contextmanager
def _noted(label: str, failed: dict[str, str]) -> Iterator[None]:
    """Whatever a reward raises is written down under its label: a plugin may raise anything."""
    try:
        yield
    except (Exception, SystemExit) as error:
        failed[label] = one_line(error)


def _columns_of(label: str, paid: Sequence[Paid]) -> Iterator[tuple[str, Float]]:
    yield label, np.concatenate([part.total for part in paid])
    for name in paid[0].terms:
        yield f"{label}/{name}", np.concatenate([part.terms[name] for part in paid])


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


def _rows_of(chunk: Chunk) -> Rows:
    """The rows of a chunk of a recording that has distances."""
    return Rows(chunk.start, chunk.begin_distance, chunk.previous_best, chunk.distance, chunk.touched, chunk.more)  # type: ignore[arg-type]
