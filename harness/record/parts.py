"""Rows in parts: Parquet files of which all but the last are full. What is written while it grows is read meanwhile."""

import time
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from harness.arrays import Float
from harness.files.bounded import whole_files
from harness.files.parquet import table_of, write_packed

PART_ROWS = 65_536
"""The rows of every part but the last."""
WRITE_EVERY, SOONEST = 4.0, 2.0
"""A training that is killed loses the steps of so many seconds at most, [s]; who watches it sees them as soon."""
LARGEST_SHARE = 0.005
"""Writing takes this share of the time at most where it is done more often than every `WRITE_EVERY`."""
Rows = Float | Sequence[Sequence[float]]


class RowsWriter:
    """Writes rows into parts, the last of them anew every few seconds; each number is exact in float64.

    Attributes:
        folder: Of the parts.
        due: When the newest part is written again, by `time.monotonic`.
    """

    def __init__(self, folder: Path, name: Callable[[int], str]) -> None:
        """Begin before the first row.

        Args:
            folder: Of the parts.
            name: The name of each part, by its number.
        """
        self.folder, self._name = folder, name
        self._part = self._filled = 0
        self.due = time.monotonic() + SOONEST

    def append(self, rows: Rows) -> None:
        """Take rows, (n, numbers), which may be used again.

        Raises:
            OSError: They cannot be written.
        """
        while len(rows):
            if self._filled == len(self._block):
                self._write()
                self._part, self._filled = self._part + 1, 0
            taken = rows[: len(self._block) - self._filled]
            self._block[self._filled : self._filled + len(taken)] = taken
            self._filled += len(taken)
            rows = rows[len(taken) :]
        if time.monotonic() >= self.due:
            self._write()

    def keep(self) -> int:
        """Write what there is, so that it survives a machine that stops; gives the number of rows.

        Raises:
            OSError: It cannot be written.
        """
        self._write()
        return self._part * len(self._block) + self._filled

    def _make_room(self, schema: pa.Schema, rows: int = 0) -> None:
        """For the rows of a part, so many if not `PART_ROWS`; columns of a row stand in the order of the schema."""
        self._schema = schema
        self._block = np.empty((rows or PART_ROWS, sum(getattr(kind, "list_size", 1) for kind in schema.types)))

    def _go_on(self, rows: int, read: Callable[[Path], Iterable[NDArray[Any]]]) -> None:
        """Go on behind so many rows, at least one; `read` gives the columns of the part that holds the last one."""
        self._part, last = divmod(rows - 1, len(self._block))
        self._filled = last + 1
        columns = [column[: self._filled] for column in read(self.folder / self._name(self._part))]
        self._block[: self._filled] = np.column_stack(columns)

    def _files(self) -> dict[str, Callable[[Path], None]]:
        """What is written, by name and in this order."""
        rows = table_of(self._block[: self._filled], self._schema)
        return {self._name(self._part): partial(write_packed, rows)}

    def _write(self) -> None:
        begun = time.thread_time()
        files = self._files()
        # Without rows nothing would be lost, and beginning a training does not wait for the disk.
        with whole_files(self.folder, [*files], is_lasting=self._filled > 0) as partials:
            for path, write in zip(partials, files.values(), strict=True):
                write(path)
        took = time.thread_time() - begun
        self.due = time.monotonic() + min(WRITE_EVERY, max(SOONEST, took / LARGEST_SHARE))
