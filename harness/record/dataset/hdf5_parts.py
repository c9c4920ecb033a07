"""Parts of an HDF5 file that anybody may have made: nothing of another file, nothing twice, nothing without end."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from harness.errors import SchemaError, UsageError
from harness.record.dataset.dataset import MOST_KEYS, MOST_NUMBERS, Nested

CHUNK_BYTES = 2**28
"""The most bytes of a chunk: HDF5 unpacks it whole."""
DEEPEST = 8


def open_hdf5(path: Path) -> Any:
    """The file, open for reading.

    Raises:
        UsageError: h5py is not installed.
    """
    try:
        import h5py
    except ImportError as error:
        raise UsageError(
            f"A Minari data set needs h5py, which cannot be imported ({error}): pip install 'fd100-harness[minari]'"
        ) from error
    return h5py.File(path, "r", locking=False)


def address(found: Any) -> int:
    """Where an object begins in its file: the same of two names for one object."""
    import h5py

    return int(h5py.h5o.get_info(found.id).addr)


def group_of(path: Path, parent: Any, key: str) -> Any:
    """A group in a group; see `member_of`.

    Raises:
        SchemaError: It is none.
    """
    found = member_of(path, parent, key)
    if hasattr(found, "dtype"):
        raise SchemaError(f"{path}: {found.name} is no group")
    return found


def member_of(path: Path, parent: Any, key: str) -> Any:
    """A part of a group; one that lies in another file is refused.

    Raises:
        SchemaError: It is missing, leads to another file, or is too large to be unpacked.
    """
    import h5py

    link = parent.get(key, getlink=True)
    if link is None:
        raise SchemaError(f"{path}: {parent.name} has no {key}")
    if not isinstance(link, h5py.HardLink):
        raise SchemaError(f"{path}: {parent.name}/{key} is a link to somewhere else, which is not followed")
    found = parent[key]
    if isinstance(found, h5py.Datatype):
        raise SchemaError(f"{path}: {found.name} is a type, no data")
    if isinstance(found, h5py.Dataset):
        if found.external or found.is_virtual:
            raise SchemaError(f"{path}: {found.name} takes its numbers from other files, which is not followed")
        if found.chunks and math.prod(found.chunks) * found.dtype.itemsize > CHUNK_BYTES:
            raise SchemaError(f"{path}: {found.name} has chunks of more than {CHUNK_BYTES:,} bytes")
    elif len(found) > MOST_KEYS:
        raise SchemaError(f"{path}: {found.name} has {len(found):,} parts, {MOST_KEYS:,} are allowed")
    return found


class Walk:
    """Looks at what stands below a group: each group once, and no more than `MOST_KEYS` parts of all of them."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._groups: set[int] = set()
        self._count = 0

    def numbers(self, group: Any, prefix: str = "", depth: int = 0) -> Iterator[tuple[str, Any]]:
        """All arrays of numbers at any depth, by key, ``a/b``; an array of one number has no rows."""
        for key, found in self._members(group, depth, frozenset()):
            if not hasattr(found, "dtype"):
                yield from self.numbers(found, f"{prefix}{key}/", depth + 1)
            elif found.dtype.kind in "biuf" and numbers_of_row(found) <= MOST_NUMBERS:
                yield f"{prefix}{key}", found

    def nested(self, found: Any, left_out: frozenset[str], place: str, depth: int = 0) -> Nested:
        """An observation or an action as arrays in the file.

        Args:
            found: What stands in the file.
            left_out: Places that are not looked at.
            place: Its own.
            depth: How deep it stands in the episode.

        Raises:
            SchemaError: It holds no rows of numbers.
        """
        if hasattr(found, "dtype"):
            if found.ndim < 1 or found.dtype.kind not in "biuf" or numbers_of_row(found) > MOST_NUMBERS:
                raise SchemaError(f"{self._path}: {found.name} holds no rows of at most {MOST_NUMBERS:,} numbers")
            return found
        skipped = frozenset(name for name in found if f"{place}/{name}" in left_out) if left_out else left_out
        parts = {
            name: self.nested(part, left_out, f"{place}/{name}", depth + 1)
            for name, part in self._members(found, depth, skipped)
        }
        if parts and all(f"_index_{number}" in parts for number in range(len(parts))):
            return tuple(parts[f"_index_{number}"] for number in range(len(parts)))
        return parts

    def _members(self, group: Any, depth: int, skipped: frozenset[str]) -> Iterator[tuple[str, Any]]:
        if depth > DEEPEST:
            raise SchemaError(f"{self._path}: {group.name} is nested too deeply")
        where = address(group)
        if where in self._groups:
            raise SchemaError(f"{self._path}: {group.name} is another name for a group that stands elsewhere too")
        self._groups.add(where)
        for key in group:
            if key in skipped:
                continue
            self._count += 1
            if self._count > MOST_KEYS:
                raise SchemaError(f"{self._path}: {group.name}: an episode has more than {MOST_KEYS:,} parts")
            yield key, member_of(self._path, group, key)


def numbers_of_row(found: Any) -> int:
    """How many numbers a row of an array has."""
    return math.prod(found.shape[1:])
