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
    if is_array(found):
        raise SchemaError(f"{path}: {found.name} is no group")
    return found


def member_of(path: Path, parent: Any, key: str) -> Any:
    """A part of a group; one that lies in another file is refused.

    Raises:
        SchemaError: It is missing, leads to another file, or is too large to be unpacked.
    """
    import h5py
    from h5py import h5d, h5g, h5l, h5o

    name = f"{parent.name}/{key}"
    try:
        link = parent.id.links.get_info(key.encode()).type
    except (KeyError, ValueError):  # text that is no name
        raise SchemaError(f"{path}: {parent.name} has no {key}") from None
    if link != h5l.TYPE_HARD:
        raise SchemaError(f"{path}: {name} is a link to somewhere else, which is not followed")
    found = h5o.open(parent.id, key.encode())  # h5py's own brackets look up the file for each part
    if isinstance(found, h5g.GroupID):
        if found.get_num_objs() > MOST_KEYS:
            raise SchemaError(f"{path}: {name} has {found.get_num_objs():,} parts, {MOST_KEYS:,} are allowed")
        return h5py.Group(found)
    if not isinstance(found, h5d.DatasetID):
        raise SchemaError(f"{path}: {name} is a type, no data")
    plan = found.get_create_plist()
    layout = plan.get_layout()
    if layout == h5d.VIRTUAL or plan.get_external_count():
        raise SchemaError(f"{path}: {name} takes its numbers from other files, which is not followed")
    if layout == h5d.CHUNKED and math.prod(plan.get_chunk()) * found.get_type().get_size() > CHUNK_BYTES:
        raise SchemaError(f"{path}: {name} has chunks of more than {CHUNK_BYTES:,} bytes")
    return h5py.Dataset(found, readonly=True)


class Walk:
    """Looks at what stands below a group: each group once, and no more than `MOST_KEYS` parts of all of them."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._groups: set[int] = set()
        self._count = 0

    def numbers(self, group: Any, prefix: str = "", depth: int = 0) -> Iterator[tuple[str, Any]]:
        """All arrays of numbers at any depth, by key, ``a/b``; an array of one number has no rows."""
        for key, found in self._members(group, depth, frozenset()):
            if not is_array(found):
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
        if is_array(found):
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


def is_array(found: Any) -> bool:
    """Whether a part holds rows; h5py would make up the type of its numbers for ``hasattr(found, "dtype")``."""
    return hasattr(type(found), "dtype")


def numbers_of_row(found: Any) -> int:
    """How many numbers a row of an array has."""
    return math.prod(found.shape[1:])
