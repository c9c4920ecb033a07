"""A LeRobot data set: a folder of JSON and Parquet files, read by pyarrow alone; its videos are left out.

A frame holds what was seen and what was done then, and under names that begin with ``next.`` what came of it. What was
seen after the last frame of an episode is not recorded: its pay and its success count, but no function can look at what
came next. `harness export` writes that too, as ``next.observation.state``.
"""

import math
from collections.abc import Iterator, Mapping
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from numpy.typing import NDArray

from harness.errors import SchemaError, UsageError
from harness.files.bounded import reading, require_regular
from harness.record.dataset.census import Census, take_census
from harness.record.dataset.dataset import (
    NOTHING_SEEN,
    OPERATOR_KEYS,
    OWN_REWARDS,
    PIECE_BYTES,
    RECORDED,
    ROWS,
    SUCCESS_KEYS,
    Dataset,
    DatasetFacts,
    Nested,
    Piece,
    flaw_of,
    own_rewards,
    require_readable,
)
from harness.record.dataset.labels import UNKNOWN, SuccessRule, missing_key, success_rule
from harness.record.dataset.lerobot_facts import (
    ACTION,
    CHUNK,
    DATA_PATH,
    EPISODE,
    FILE,
    FRAME,
    INFO,
    MOST_FILES,
    NEEDED,
    NEXT_STATE,
    REWARD,
    SEEN,
    STATE,
    TASK,
    TASKS,
    Listing,
    count_of,
    names_of,
    read_info,
    read_listing,
    read_tasks,
    reward_in,
    seen_in,
    shapes_of,
    version_of,
)
from harness.text import shortened

MOST_BYTES = 2**35
GROUP_BYTES = 2**30
"""The most bytes of a group of rows, unpacked."""


class _Layout(NamedTuple):
    """What is read of each file, and what is known of each episode."""

    files: tuple[Path, ...]
    shapes: Mapping[str, tuple[int, ...]]
    own: Mapping[str, str]
    listing: Listing
    tasks: Mapping[int, str]
    episodes: frozenset[int]
    rule: SuccessRule | None

    @property
    def keys(self) -> tuple[str, ...]:
        """Columns that are told beside what was seen and done."""
        return tuple(name for name in self.shapes if name not in (*self.seen, ACTION, NEXT_STATE))

    @property
    def seen(self) -> tuple[str, ...]:
        """Columns of an observation."""
        return seen_in(self.shapes)

    def of_episode(self, number: int, key: str) -> Any:
        """What the list of episodes says under a key."""
        return self.listing.rows.get(number, {}).get(key)


def open_lerobot(name: str, success: SuccessRule | None, cluster: str = "", partial_is_enough: bool = False) -> Dataset:
    """A data set; its steps are read later.

    Args:
        name: Its folder.
        success: Where success stands, in a column or in the list of episodes; found by its name if it has no key. None
            where it is not looked for.
        cluster: The column, or the key of an episode, that says who made it; found by its name if empty.
        partial_is_enough: Whether less than the metadata declares may be there.

    Raises:
        UsageError: It is not there.
        NewerFormat: Its layout is of a newer version.
        SchemaError: It is damaged, lacks a column, or is not what its metadata declares.
    """
    folder = Path(name).expanduser()
    path = folder / INFO
    if not path.is_file():
        raise UsageError(f"No LeRobot data set at '{name}': name its folder, which holds {INFO}")
    with reading(path, "LeRobot data set"):
        info = read_info(path)
        version = version_of(path, info)
        features = info["features"]
        shapes = shapes_of(path, features)
        own = own_rewards(path, info.get(OWN_REWARDS), shapes, (reward_in(shapes), *NEEDED, STATE, NEXT_STATE))
        listing, tasks = read_listing(folder), read_tasks(folder)
        files, notes = _files(folder, info, listing)
    census = _census(folder, files, shapes, listing, info, partial_is_enough)
    layout = _Layout(files, shapes, own, listing, tasks, census.episodes, None)
    told = (*layout.keys, *listing.keys)
    usual = [f"{begin}{key}" for key in SUCCESS_KEYS for begin in ("next.", "")]
    rule = success_rule(success, told, folder, usual)
    if cluster and cluster not in told:
        raise missing_key("--cluster", cluster, folder, told)
    facts = DatasetFacts(
        f"lerobot:{name}",
        folder,
        f"LeRobot v{'.'.join(map(str, version))}",
        env=shortened(str(info.get("robot_type") or ""), 200),
        names={"observation": names_of(features, STATE), "action": names_of(features, ACTION)},
        rewards=(*((RECORDED,) if reward_in(shapes) else ()), *own.values()),
        success="" if rule is None else rule.text,
        operator=cluster or next((key for key in OPERATOR_KEYS if key in told), ""),
        task=TASK if TASK in shapes else TASKS if TASKS in listing.keys else "",
        declared_tasks=count_of(info.get("total_tasks")),
        pictures_left_out=any(name.startswith(SEEN) and name not in shapes for name in features),
        notes=(*notes, *_notes_on_seen(shapes), *census.notes),
    )
    return Dataset(facts, partial(_pieces, facts, layout._replace(rule=rule)))


def _notes_on_seen(shapes: Mapping[str, Any]) -> list[str]:
    if STATE in shapes:
        return []
    parts = ", ".join(name.removeprefix(SEEN) for name in seen_in(shapes))
    found = f"an observation is a dictionary of {parts}" if parts else NOTHING_SEEN
    return [f"There are no numbers of {STATE}: {found}"]


def _files(folder: Path, info: Mapping[str, Any], listing: Listing) -> tuple[tuple[Path, ...], list[str]]:
    """The files of frames, and what is told of those that are left out. Since v3.0 the list of episodes names them."""
    found = sorted((folder / "data").glob("*/*.parquet"))
    if len(found) > MOST_FILES:
        raise SchemaError(f"{folder} has {len(found):,} files, {MOST_FILES:,} are allowed")
    if {CHUNK, FILE} <= {*listing.keys} and info.get("data_path", DATA_PATH) == DATA_PATH:
        rows = listing.rows.values()
        numbers = [count_of(row.get(key)) for row in rows for key in (CHUNK, FILE)]
        if not all(number is not None and number < MOST_FILES for number in numbers):
            raise SchemaError(f"{listing.path} names a file by {CHUNK} and {FILE} that are no numbers of files")
        places = {(row[CHUNK], row[FILE]) for row in rows}
        named = {folder / DATA_PATH.format(chunk_index=chunk, file_index=file) for chunk, file in places}
        beside = [path for path in found if path not in named]
        found = [path for path in found if path in named]
    else:
        beside = []
    if not found:
        raise SchemaError(f"{folder} has no file data/*/*.parquet that belongs to it")
    names = ", ".join(path.relative_to(folder).as_posix() for path in beside[:3])
    return tuple(found), [
        f"Left out, since no episode stands in them: {len(beside):,} files ({names})"
    ] if beside else []


def _census(
    folder: Path,
    files: tuple[Path, ...],
    shapes: Mapping[str, tuple[int, ...]],
    listing: Listing,
    info: Mapping[str, Any],
    partial_is_enough: bool,
) -> Census:
    """Count the frames of each episode, which takes one column."""
    found: dict[int, int] = {}
    width, total = sum(math.prod(shape) for shape in shapes.values()), 0
    for path in files:
        with reading(path, "LeRobot data set"):
            require_regular(path, MOST_BYTES)
            with pq.ParquetFile(path) as file:
                _require_columns(path, file, shapes)
                total += file.metadata.num_rows
                require_readable(folder, total, width)
                for batch in file.iter_batches(columns=[EPISODE]):
                    numbers, counts = np.unique(_array(path, batch, EPISODE, (1,), 0), return_counts=True)
                    for number, count in zip(numbers.tolist(), counts.tolist(), strict=True):
                        found[int(number)] = found.get(int(number), 0) + count
    return take_census(folder, listing.declared(info), found, partial_is_enough)


def _pieces(facts: DatasetFacts, layout: _Layout) -> Iterator[Piece]:
    rows = _Frames(facts, layout)
    for path in layout.files:
        with reading(path, "LeRobot data set"):
            yield from rows.take(path)
    with reading(layout.files[-1], "LeRobot data set"):
        yield from rows.end()


class _Frames:
    """Turns frames into pieces. The last frame of an episode waits for the next one, which may be its next."""

    def __init__(self, facts: DatasetFacts, layout: _Layout) -> None:
        self._facts, self._layout = facts, layout
        self._waiting: dict[str, NDArray[Any]] = {}
        self._file = ""
        self._has_next = {STATE, NEXT_STATE} <= {*layout.shapes}
        width = 8 * sum(math.prod(shape) for shape in layout.shapes.values())
        self._rows = max(2, min(ROWS, PIECE_BYTES // width))
        self._seen: set[int] = set()
        self._number = self._at = -1  # the episode, and its frame that waits

    def take(self, path: Path) -> Iterator[Piece]:
        with pq.ParquetFile(path) as file:
            first = 0
            for batch in file.iter_batches(self._rows, columns=list(self._layout.shapes)):
                table = {name: _array(path, batch, name, shape, first) for name, shape in self._layout.shapes.items()}
                first += batch.num_rows
                yield from self._take(table, path.relative_to(self._facts.path).as_posix())

    def end(self) -> Iterator[Piece]:
        if self._waiting:
            yield from self._piece(self._waiting, ends=True)

    def _take(self, table: dict[str, NDArray[Any]], file: str) -> Iterator[Piece]:
        if not len(table[EPISODE]):
            return
        if self._waiting and self._waiting[EPISODE][0] == table[EPISODE][0]:
            table = {name: np.concatenate([self._waiting[name], values]) for name, values in table.items()}
        elif self._waiting:
            yield from self._piece(self._waiting, ends=True)
        self._file = file
        bounds = [0, *(np.flatnonzero(np.diff(table[EPISODE])) + 1).tolist(), len(table[EPISODE])]
        *whole, last = ({name: values[a:b] for name, values in table.items()} for a, b in pairwise(bounds))
        for one in whole:
            yield from self._piece(one, ends=True)
        yield from self._piece(last, ends=False)
        self._waiting = {name: values[-1:] for name, values in last.items()}

    def _piece(self, table: dict[str, NDArray[Any]], ends: bool) -> Iterator[Piece]:
        """The steps of some frames of one episode; if it goes on, the last frame waits."""
        number = int(table[EPISODE][0])
        where = f"{self._facts.path / self._file}, episode {number}"
        self._require_order(table[FRAME], number, where)
        count = len(table[FRAME]) if ends else len(table[FRAME]) - 1
        if count == 0 or number not in self._layout.episodes:
            return
        state = self._seen_in(table, count, ends)
        action, rewards = table[ACTION][:count], self._rewards(table, count)
        yield Piece(
            number,
            int(table[FRAME][0]),
            state,
            action,
            {name: table[name][:count] for name in self._layout.keys if name not in self._layout.own},
            rewards,
            self._told(table, count, number, where, ends),
            self._of(table, number, self._facts.operator),
            self._task(table, number),
            self._file,
            ends,
            flaw_of(state, " or ".join(self._layout.seen)) or flaw_of(action, ACTION) or flaw_of(rewards, REWARD),
        )

    def _seen_in(self, table: Mapping[str, NDArray[Any]], count: int, ends: bool) -> Nested:
        """The observations of some steps, and what was seen after them where that is known."""
        rows = count if ends else count + 1
        parts = {name.removeprefix(SEEN): table[name][:rows] for name in self._layout.seen}
        if self._has_next:
            return np.concatenate([table[STATE][:count], table[NEXT_STATE][count - 1 : count]])
        if STATE in table:
            return table[STATE][:rows]
        return parts or np.empty((rows, 0), np.float32)

    def _require_order(self, frame: NDArray[Any], number: int, where: str) -> None:
        begins = number not in self._seen and frame[0] == 0
        goes_on = number == self._number and frame[0] == self._at
        if not (begins or goes_on) or (np.diff(frame.astype(np.int64)) != 1).any():
            raise SchemaError(
                f"{where}: its frames do not follow one another, from 0 on. Sort the rows by {EPISODE} and {FRAME}"
            )
        self._seen.add(number)
        self._number, self._at = number, int(frame[-1])

    def _rewards(self, table: Mapping[str, NDArray[Any]], count: int) -> dict[str, NDArray[np.float64]]:
        columns = {RECORDED: reward_in(self._layout.shapes), **{name: key for key, name in self._layout.own.items()}}
        return {name: np.asarray(table[columns[name]][:count], np.float64).ravel() for name in self._facts.rewards}

    def _told(
        self, table: Mapping[str, NDArray[Any]], count: int, number: int, where: str, ends: bool
    ) -> NDArray[np.int8]:
        rule = self._layout.rule
        if rule is not None and rule.key in table:
            return rule.of_steps(table[rule.key][:count], f"{where}: {rule.key}")
        told = np.full(count, UNKNOWN, np.int8)
        if rule is not None and ends:
            value = self._layout.of_episode(number, rule.key)
            told[-1] = rule.of_episode(value, f"{self._layout.listing.path}, episode {number}: {rule.key}")
        return told

    def _of(self, table: Mapping[str, NDArray[Any]], number: int, key: str) -> str:
        """What is said of the episode: by its first frame, or by the list of episodes."""
        if key in table:
            return f"{np.asarray(table[key]).ravel()[0]}"
        told = self._layout.of_episode(number, key)
        return "" if told is None else shortened(str(told), 200)

    def _task(self, table: Mapping[str, NDArray[Any]], number: int) -> str:
        if self._facts.task == TASK:
            numbers = np.unique(np.asarray(table[TASK])).tolist()
            return " + ".join(self._layout.tasks.get(it, str(it)) for it in numbers)
        told = self._layout.of_episode(number, TASKS)
        return shortened(" + ".join(map(str, told)) if isinstance(told, list) else str(told or ""), 200)


def _require_columns(path: Path, file: pq.ParquetFile, shapes: Mapping[str, Any]) -> None:
    missing = [name for name in shapes if name not in file.schema_arrow.names]
    if missing:
        raise SchemaError(f"{path} has no column {', '.join(missing)}, of which {INFO} tells")
    for number in range(file.metadata.num_row_groups):
        if file.metadata.row_group(number).total_byte_size > GROUP_BYTES:
            raise SchemaError(f"{path} has a group of rows of more than {GROUP_BYTES:,} bytes")


def _array(path: Path, batch: pa.RecordBatch, name: str, shape: tuple[int, ...], first: int) -> NDArray[Any]:
    """A column, (rows,) where the shape is one number, else (rows, ...).

    Args:
        path: The file.
        batch: Some of its rows.
        name: Of the column.
        shape: That its rows should have.
        first: Number of the first row in the file.

    Raises:
        SchemaError: It has gaps, or rows of another shape.
    """
    column = batch.column(name)
    noun = f"{path}: {name} has gaps, or other rows than the {list(shape)} that {INFO} tells"
    for level, size in enumerate(_sizes(column.type, shape, noun)):
        lengths = pc.fill_null(pc.list_value_length(column), -1).to_numpy(zero_copy_only=False)
        odd = np.flatnonzero(lengths != size)
        if len(odd):
            raise SchemaError(f"{noun}; the first is row {first + int(odd[0]) // math.prod(shape[:level])}")
        column = column.flatten()
    if isinstance(column, pa.ExtensionArray):
        raise SchemaError(f"{path}: {name} is of the type {column.type}, not of lists of numbers")
    if column.null_count and name in (EPISODE, FRAME, TASK):
        raise SchemaError(noun)
    if column.null_count:  # what pandas writes for a number that is none
        column = column.cast(pa.float64())
    values = np.asarray(column.to_numpy(zero_copy_only=False))
    if values.dtype.kind not in "biuf":
        raise SchemaError(f"{path}: {name} holds {values.dtype}, no numbers")
    return values if shape == (1,) and name not in (STATE, ACTION) else values.reshape(batch.num_rows, *shape)


def _sizes(kind: pa.DataType, shape: tuple[int, ...], noun: str) -> tuple[int, ...]:
    """How long the lists of a column are at each depth: one for each number of the shape, or one for all."""
    depth = 0
    while pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind) or pa.types.is_large_list(kind):
        kind, depth = kind.value_type, depth + 1
    sizes = {len(shape): shape, 1: (math.prod(shape),), **({0: ()} if math.prod(shape) == 1 else {})}
    if depth not in sizes:
        raise SchemaError(noun)
    return sizes[depth]
