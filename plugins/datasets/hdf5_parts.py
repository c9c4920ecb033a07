"""Parts of an HDF5 file that anybody may have made: nothing of another file, nothing twice, nothing without end."""

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness import Ints
from harness.errors import SchemaError
from harness.files import open_regular, reading
from harness.record.dataset.open_dataset import MOST_EPISODES, open_hdf5

from .dataset import MOST_KEYS, MOST_NUMBERS, require_readable, rows_at_once
from .steps import Source, Steps, nothing_told

MOST_BYTES = 2**40
CHUNK_BYTES = 2**28
"""The most bytes of a chunk: HDF5 unpacks it whole."""
DEEPEST = 8


class Array:
    """Numbers or texts in the file, (rows, ...), or one of them. They are read later; what it looks like is known.

    Attributes:
        shape: Of all of it.
        dtype: Of a number.
    """

    __slots__ = ("_found", "dtype", "shape")

    def __init__(self, found: Any) -> None:
        """Take what `h5py.h5o.open` found."""
        self._found = found
        self.shape: tuple[int, ...] = found.shape
        self.dtype: np.dtype[Any] = found.dtype

    def __len__(self) -> int:
        return self.shape[0] if self.shape else 0

    def __getitem__(self, rows: slice) -> NDArray[Any]:
        """Some rows. All, or all but one, are read past h5py's selections, which take longer than an episode."""
        import h5py

        begin, end, _ = rows.indices(len(self))
        if end - begin < len(self) - 1 or not self.size or self.dtype.hasobject:
            return np.asarray(h5py.Dataset(self._found, readonly=True)[begin:end])
        values = np.empty(self.shape, self.dtype)
        self._found.read(h5py.h5s.ALL, h5py.h5s.ALL, values)
        return values[begin:end]

    @property
    def size(self) -> int:
        """How many numbers there are."""
        return math.prod(self.shape)

    @property
    def width(self) -> int:
        """How many numbers a row has."""
        return math.prod(self.shape[1:])

    @property
    def value(self) -> Any:
        """All of it, of whatever shape.

        Raises:
            ValueError: It is too large for what says one thing, or lists names.
        """
        import h5py

        if self.size > MOST_EPISODES:
            raise ValueError(f"an array of names has {self.size:,}, {MOST_EPISODES:,} are allowed")
        return h5py.Dataset(self._found, readonly=True)[()]

    @property
    def holds_numbers(self) -> bool:
        """Whether it has rows of numbers, and not too many in each."""
        return self.dtype.kind in "biuf" and self.width <= MOST_NUMBERS


class Stretch(NamedTuple):
    """Consecutive rows of an array, one for each step of an episode."""

    array: Array
    first: int = 0
    """The row of the first step."""


def address(found: Any) -> int:
    """Where a group begins in its file: the same of two names for one group."""
    import h5py

    return int(h5py.h5o.get_info(found.id).addr)


def group_of(parent: Any, key: str, most: int = MOST_KEYS) -> Any:
    """A group in a group, of at most so many parts; see `member_of`.

    Raises:
        SchemaError: It is none, or has more parts.
    """
    found = member_of(parent, key)
    if isinstance(found, Array):
        raise SchemaError(f"{_place(parent, key)} is no group")
    if len(found) > most:
        raise SchemaError(f"{_place(parent, key)} has {len(found):,} parts, {most:,} are allowed")
    return found


def array_of(parent: Any, key: str) -> Array:
    """An array in a group, or in groups of it; see `find_array`.

    Raises:
        SchemaError: There is none.
    """
    found = find_array(parent, key)
    if found is None:
        raise SchemaError(f"{parent.file.filename}: {parent.name} has no {key}, or a group in its place")
    return found


def find_array(parent: Any, key: str) -> Array | None:
    """An array in a group, or in groups of it, ``a/b``; None if there is none."""
    found = parent
    for name in key.split("/"):
        if isinstance(found, Array) or not found.id.links.exists(name.encode()):
            return None
        found = member_of(found, name)
    return found if isinstance(found, Array) else None


def member_of(parent: Any, key: str) -> Any:
    """A group or an `Array` in a group; one that lies in another file is refused.

    Raises:
        SchemaError: It is missing, leads to another file, or is too large to be unpacked.
    """
    import h5py
    from h5py import h5d, h5g, h5l, h5o

    try:
        link = parent.id.links.get_info(key.encode()).type
    except (KeyError, RuntimeError, ValueError):  # none of that name, or text that is no name
        raise SchemaError(f"{parent.file.filename}: {parent.name} has no {key}") from None
    if link != h5l.TYPE_HARD:
        raise SchemaError(f"{_place(parent, key)} is a link to somewhere else, which is not followed")
    found = h5o.open(parent.id, key.encode())  # h5py's own brackets look up the file for each part
    if isinstance(found, h5g.GroupID):
        return h5py.Group(found)
    if not isinstance(found, h5d.DatasetID):
        raise SchemaError(f"{_place(parent, key)} is a type, no data")
    array, plan = Array(found), found.get_create_plist()
    layout = plan.get_layout()
    if layout == h5d.VIRTUAL or (layout == h5d.CONTIGUOUS and plan.get_external_count()):
        raise SchemaError(f"{_place(parent, key)} takes its numbers from other files, which is not followed")
    if layout == h5d.CHUNKED and math.prod(plan.get_chunk()) * array.dtype.itemsize > CHUNK_BYTES:
        raise SchemaError(f"{_place(parent, key)} has chunks of more than {CHUNK_BYTES:,} bytes")
    return array


def _place(parent: Any, key: str) -> str:
    """Where a part stands, behind the name of its file: ``low_dim.hdf5: /data/demo_0``."""
    return f"{parent.file.filename}: {parent.name.rstrip('/')}/{key}"


class Walk:
    """Looks at what stands below a group: each group once, and no more than `MOST_KEYS` parts of all of them."""

    def __init__(self) -> None:
        self._groups: set[int] = set()
        self._count = 0

    def arrays(
        self, found: Any, place: str, left_out: Collection[str] = (), depth: int = 0
    ) -> Iterator[tuple[str, Array]]:
        """The arrays of what stands at a place, at any depth, by place, ``observations/goal``.

        Args:
            found: What stands in the file.
            place: Its own.
            left_out: Places that are not looked at.
            depth: How deep it stands in the episode.

        Raises:
            SchemaError: It is nested without end, or has too many parts.
        """
        if isinstance(found, Array):
            yield place, found
            return
        where = f"{found.file.filename}: {found.name}"
        if depth > DEEPEST:
            raise SchemaError(f"{where} is nested too deeply")
        if (begin := address(found)) in self._groups:
            raise SchemaError(f"{where} is another name for a group that stands elsewhere too")
        self._groups.add(begin)
        for key in found:
            self._count += 1
            if self._count > MOST_KEYS:
                raise SchemaError(f"{where}: an episode has more than {MOST_KEYS:,} parts")
            if (inner := f"{place}/{key}") not in left_out:
                yield from self.arrays(member_of(found, key), inner, left_out, depth + 1)


def infos_of(episode: Any) -> dict[str, Array]:
    """The arrays of numbers among the infos of an episode, by key, ``a/b``."""
    if "infos" not in episode:
        return {}
    found = Walk().arrays(group_of(episode, "infos"), "infos")
    return {place.removeprefix("infos/"): array for place, array in found if array.holds_numbers}


def read_stretches(steps: int, parts: Mapping[str, Stretch]) -> Iterator[tuple[slice, dict[str, NDArray[Any]]]]:
    """The rows of some steps after another, by column, and which steps these are, counted from 0.

    An array that two columns read, such as observations before and after each step, is read once.
    """
    spans: dict[Array, tuple[int, int]] = {}
    for array, first in parts.values():
        low, high = spans.get(array, (first, first))
        spans[array] = min(low, first), max(high, first)
    rows = rows_at_once(sum(array.dtype.itemsize * array.width for array in spans))
    for begin in range(0, steps, rows):
        end = min(begin + rows, steps)
        held = {array: array[begin + low : end + high] for array, (low, high) in spans.items()}
        yield (
            slice(begin, end),
            {name: held[array][first - spans[array][0] :][: end - begin] for name, (array, first) in parts.items()},
        )


@contextmanager
def opened(path: Path, noun: str) -> Iterator[Any]:
    """An HDF5 file, open for reading; `noun` says what it should be."""
    with reading(path, noun), open_regular(path, MOST_BYTES), open_hdf5(path) as file:
        yield file


class Run(NamedTuple):
    """Steps of an episode, or of several that follow one another in the same arrays.

    Attributes:
        episode: The number of each step's episode, (steps,).
        parts: By column where the numbers of all steps stand.
        where: They stand, for messages.
        told: See `Source.columns`.
        known: Further columns, (steps,).
    """

    episode: Ints
    parts: Mapping[str, Stretch]
    where: str
    told: Callable[[int, str], Any] = nothing_told
    known: Mapping[str, NDArray[Any]] = {}


def tables_of(
    path: Path, source: Source, runs: Callable[[Any, tuple[str, ...]], Iterable[Run]], names: tuple[str, ...]
) -> Iterator[dict[str, NDArray[Any]]]:
    """Some columns of the steps of all runs.

    Args:
        path: The file.
        source: What is known of it.
        runs: Finds them in the open file, with what these columns need.
        names: Of the columns.

    Raises:
        SchemaError: They hold too many numbers, or do not fit together.
    """
    numbers = 0
    with opened(path, f"{source.facts.format} data set") as file:
        for episode, parts, where, told, known in runs(file, names):
            numbers += len(episode) * sum(array.width for array in {part.array for part in parts.values()})
            require_readable(path, 1, numbers)
            if not len(episode):
                continue
            row, begins = np.arange(len(episode)), np.diff(episode, prepend=-1) != 0
            step = row - np.maximum.accumulate(np.where(begins, row, 0)) + 1
            ends = np.append(begins[1:], True)
            for rows, table in read_stretches(len(episode), parts):
                found = {"step": step[rows], **{name: values[rows] for name, values in known.items()}, **table}
                yield source.columns(names, Steps(found, episode[rows], ends[rows], where), told)
