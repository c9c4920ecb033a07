"""The rings of a checkpoint: each in files of its own, to which every checkpoint adds the rows that are new."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Self
from urllib.parse import quote

import numpy as np
import safetensors.numpy
from numpy.typing import NDArray

from harness.errors import SchemaError
from harness.files.bounded import digest_of
from harness.files.names import is_plain
from harness.files.whole_file import whole_file
from harness.progress import Ring


class RingPart(NamedTuple):
    """A file with rows `first` to `end` - 1, counted from the first that was ever written."""

    file: str
    first: int
    end: int
    digest: str


@dataclass(frozen=True)
class StoredRing:
    """The files that hold the rows of a ring.

    Attributes:
        capacity: See `harness.progress.Ring`.
        written: The same.
        parts: The files, oldest first.
    """

    capacity: int
    written: int
    parts: tuple[RingPart, ...] = ()

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """The ring's files from what `dataclasses.asdict` returned, after it was read from JSON."""
        return cls(data["capacity"], data["written"], tuple(RingPart(*part) for part in data["parts"]))

    @property
    def oldest(self) -> int:
        """The first row that is still in the ring."""
        return max(self.written - self.capacity, 0)


def store_ring(folder: Path, name: str, ring: Ring, before: StoredRing | None) -> StoredRing:
    """Write the rows that are new since `before`, if there is a `before`; returns where all rows are."""
    stored = StoredRing(len(next(iter(ring.columns.values()))), ring.written)
    if before is None or before.written > ring.written:  # the ring was emptied
        before = StoredRing(stored.capacity, 0)
    kept = tuple(part for part in before.parts if part.end > stored.oldest)
    first = max(before.written, stored.oldest)
    if first < ring.written:
        file = f"ring.{quote(name, safe='')}.{first}-{ring.written}.safetensors"
        rows = {column: _rows(array, first, ring.written) for column, array in ring.columns.items()}
        with whole_file(folder / file) as partial:
            safetensors.numpy.save_file(rows, partial)
        kept = (*kept, RingPart(file, first, ring.written, digest_of(folder / file)))
    return StoredRing(stored.capacity, stored.written, kept)


def _rows(column: NDArray[Any], first: int, end: int) -> NDArray[Any]:
    """Rows `first` to `end` - 1 of a ring's column, in order. It is no copy if they already stand in order."""
    top, count = first % len(column), end - first
    beyond = top + count - len(column)
    rows = column[top : top + count] if beyond <= 0 else np.concatenate([column[top:], column[:beyond]])
    return np.ascontiguousarray(rows)


def read_ring(folder: Path, stored: StoredRing) -> Ring:
    """The ring, as far as it was written.

    Raises:
        SchemaError: A file has other rows than the checkpoint tells.
    """
    columns: dict[str, Any] = {}
    for part in stored.parts:
        kept = np.arange(max(part.first, stored.oldest), part.end)
        for name, rows in safetensors.numpy.load_file(folder / part.file).items():
            if len(rows) != part.end - part.first:
                raise SchemaError(f"{part.file} has {len(rows):,} rows, not {part.end - part.first:,}")
            if name not in columns:
                columns[name] = np.empty((min(stored.written, stored.capacity), *rows.shape[1:]), rows.dtype)
            columns[name][kept % stored.capacity] = rows[kept - part.first]
    return Ring(columns, stored.written)


def require_rings(folder: Path, rings: Iterable[StoredRing]) -> None:
    """Check that all rows are as they were written.

    Raises:
        SchemaError: Rows, or a file, are missing or damaged.
    """
    rings = list(rings)
    for ring in rings:
        ends = [ring.oldest, *(part.end for part in ring.parts)]
        if ends[-1] != ring.written or any(part.first > end for part, end in zip(ring.parts, ends, strict=False)):
            raise SchemaError("rows of a ring are missing")
    for part in (part for ring in rings for part in ring.parts):
        path = folder / part.file
        if not is_plain(part.file) or not path.is_file() or digest_of(path) != part.digest:
            raise SchemaError(f"{part.file} is missing or damaged")


def discard_rings(folder: Path, but: Iterable[StoredRing] = ()) -> None:
    """Remove the files of all rings except those in `but`."""
    named = {part.file for ring in but for part in ring.parts}
    for path in folder.glob("ring.*.safetensors"):
        if path.name not in named:
            path.unlink()
