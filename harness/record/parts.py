"""Rows in parts: Parquet files of which all but the last are full. What is written while it grows is read meanwhile."""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import SchemaError
from harness.files.bounded import reading, whole_files
from harness.files.parquet import open_parquet, table_of, write_packed
from harness.log.log import Columns, joined
from harness.record.folder import part_path, parts_of

PART_ROWS = 65_536
"""The rows of every part but the last."""
WRITE_EVERY, SOONEST = 4.0, 2.0
"""A training that is killed loses the steps of so many seconds at most, [s]; who watches it sees them as soon."""
LARGEST_SHARE = 0.005
"""Writing takes this share of the time at most where it is done more often than every `WRITE_EVERY`."""
Rows = Float | Sequence[Sequence[float]]
PART_BYTES = 2**35
"""Most that is read of a file."""


@contextmanager
def open_part(path: Path, noun: str) -> Iterator[pq.ParquetFile]:
    """A file of rows; whatever its readers let through in the block is a SchemaError.

    Args:
        path: The file.
        noun: What it should be, ``trace``.
    """
    with reading(path, noun), open_parquet(path, PART_BYTES) as file:
        yield file


def rows_of(file: pq.ParquetFile, path: Path, names: Sequence[str]) -> Iterator[Columns]:
    """The rows of some columns, in tables: (rows,) each, or (rows, n).

    Raises:
        SchemaError: A value is missing, or rows are that the file tells of.
    """
    left = file.metadata.num_rows
    batches = file.iter_batches(PART_ROWS, columns=names, use_threads=False)
    tables = (pa.Table.from_batches([batch]) for batch in batches) if left else [file.read(names)]
    for table in tables:
        if any(column.null_count for column in table.columns):
            raise SchemaError(f"{path} has gaps")
        left -= table.num_rows
        yield {name: _numbers(table.column(name)) for name in names}
    if left:
        raise SchemaError(f"{path} lacks {left:,} rows that it tells of")


def _numbers(column: pa.ChunkedArray) -> NDArray[Any]:
    if not pa.types.is_fixed_size_list(column.type):
        return np.asarray(column.to_numpy())
    return np.asarray(column.combine_chunks().flatten().to_numpy()).reshape(len(column), column.type.list_size)


class RowsWriter:
    """Writes rows into parts, the last of them anew every few seconds; each number is exact in float64.

    Attributes:
        folder: Of the parts.
        due: When the newest part is written again, by `time.monotonic`.
    """

    def __init__(self, first: Path) -> None:
        """Begin before the first row; the other files stand beside the `first`, see `part_path`."""
        self.folder, self._first = first.parent, first
        self._part = self._filled = 0
        self.due = time.monotonic() + SOONEST

    def append(self, rows: Rows) -> None:
        """Take rows, (n, numbers), which may be used again.

        Raises:
            OSError: They cannot be written.
        """
        while len(rows) > (room := len(self._block) - self._filled):
            self._block[self._filled :] = rows[:room]
            self._filled += room
            self._write()
            self._part, self._filled, rows = self._part + 1, 0, rows[room:]
        if count := len(rows):
            self._block[self._filled : self._filled + count] = rows
            self._filled += count
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

    def _go_on(self, rows: int) -> None:
        """Go on behind so many rows, at least one; those behind them are forgotten."""
        self._part, last = divmod(rows - 1, len(self._block))
        self._filled = last + 1
        path, *later = parts_of(self._first)[self._part :]
        with open_part(path, "file of rows") as file:
            if not file.schema_arrow.equals(self._schema):
                raise SchemaError(f"{path} has other columns than are written")
            columns = joined([*rows_of(file, path, self._schema.names)])
        self._block[: self._filled] = np.column_stack([column[: self._filled] for column in columns.values()])
        for part in later:
            part.unlink()

    def _files(self) -> dict[str, Callable[[Path], None]]:
        """What is written, by name and in this order."""
        rows = table_of(self._block[: self._filled], self._schema)
        return {part_path(self._first, self._part).name: partial(write_packed, rows)}

    def _write(self) -> None:
        begun = time.thread_time()
        files = self._files()
        # Without rows nothing would be lost, and beginning a training does not wait for the disk.
        with whole_files(self.folder, [*files], is_lasting=self._filled > 0) as partials:
            for path, write in zip(partials, files.values(), strict=True):
                write(path)
        took = time.thread_time() - begun
        self.due = time.monotonic() + min(WRITE_EVERY, max(SOONEST, took / LARGEST_SHARE))
