"""A trace that is written in parts, so that a training that is killed can go on behind the last finished one."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType

import numpy as np

from harness.errors import SchemaError
from harness.files.bounded import digest_of, sync
from harness.record.trace import NO_EXTRAS, EpisodeFacts, Rows, TraceWriter, part_of, read_trace


class TraceParts:
    """A `Recorder` into files ``trace.0``, ``trace.1``, ... beside the trace that becomes of them.

    One of them is being written. A Parquet file cannot be read before it is finished, and takes no rows afterwards. The
    trace is the same file, byte for byte, in however many parts it was written.

    Attributes:
        digests: SHA-256 of each finished part.
    """

    def __init__(
        self,
        path: Path,
        dof: int,
        action_size: int,
        facts: EpisodeFacts,
        digests: Sequence[str] = (),
        extras: Mapping[str, int] = NO_EXTRAS,
    ) -> None:
        """Go on behind the parts that are finished, each of which has a digest.

        Args:
            path: The trace to be.
            dof: Length of qpos.
            action_size: Length of the action.
            facts: What is known of the episodes.
            digests: SHA-256 of each finished part.
            extras: See `TraceWriter`.
        """
        self._path, self._dof, self._action_size, self._facts = path, dof, action_size, facts
        self._extras = extras
        self.digests = list(digests)
        discard_parts(path, len(digests))
        self._writer = self._open(self._present)

    def append(self, rows: Rows) -> None:
        self._writer.append(rows)

    def cut(self) -> None:
        """Finish the present part, on the disk too, and begin the next one."""
        self._writer.close()
        sync(self._present)
        self.digests.append(digest_of(self._present))
        self._writer = self._open(self._present)

    def __enter__(self) -> "TraceParts":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        """Make one trace of the parts, a failed training's too; parts that a checkpoint may name stay."""
        try:
            self._writer.close()
        finally:
            self._merge()

    @property
    def _present(self) -> Path:
        return part_of(self._path, len(self.digests))

    def _open(self, path: Path) -> TraceWriter:
        return TraceWriter(path, self._dof, self._action_size, facts=self._facts, extras=self._extras)

    def _merge(self) -> None:
        parts = [part_of(self._path, number) for number in range(len(self.digests) + 1)]
        if len(parts) == 1:
            parts[0].replace(self._path)
            return
        names = self._writer.schema.names
        with self._open(self._path) as writer:
            for piece in (piece for part in parts for piece in read_trace(part).pieces(names)):
                writer.append(np.column_stack([piece[name] for name in names]))


def discard_parts(path: Path, first: int = 0) -> None:
    """Remove the parts of the trace `path` from number `first` on."""
    number = first
    while part_of(path, number).exists():
        part_of(path, number).unlink()
        number += 1


def require_parts(path: Path, digests: Sequence[str]) -> None:
    """Check that the finished parts of a trace have not changed.

    Raises:
        SchemaError: One is missing or damaged.
    """
    for number, digest in enumerate(digests):
        part = part_of(path, number)
        if not part.is_file() or digest_of(part) != digest:
            raise SchemaError(f"{part.name} is missing or damaged")
