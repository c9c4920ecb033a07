"""A LeRobot data set: a folder of JSON and Parquet files, read by pyarrow alone; its videos are left out.

A frame holds what was seen and what was done then, and under names that begin with ``next.`` what came of it. What was
seen after the last frame of an episode is not recorded: its pay and its success count, but no function can look at what
came next. `harness export` writes that too, as ``next.observation.state``.
"""

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.errors import SchemaError, UsageError
from harness.files.bounded import reading, require_regular
from harness.log import Log
from harness.log.log import (
    ACTION,
    BEFORE,
    BEHAVIOUR,
    FILE as FILE_COLUMN,
    INFO,
    OBSERVATION,
    OPERATOR,
    RECORDED,
    REWARD,
    SEEN,
    SUCCESS,
    TASK,
)
from harness.record.dataset.labels import UNKNOWN, SuccessRule
from harness.record.dataset.open_dataset import DatasetFacts
from harness.text import shortened

from ..datasets.dataset import (
    NOTHING_SEEN,
    OWN_REWARDS,
    SUCCESS_KEYS,
    Census,
    as_measure,
    as_texts,
    operator_key,
    own_rewards,
    require_readable,
    rows_at_once,
    success_rule,
    take_census,
    texts,
    where_seen,
    whole,
)
from ..datasets.lerobot_facts import (
    CHUNK,
    DATA_PATH,
    DONE,
    EPISODE,
    FILE,
    FRAME,
    INFO_FILE,
    MOST_FILES,
    NEEDED,
    NEXT_STATE,
    SEEN_BEGIN,
    STATE,
    TASK_INDEX,
    TASKS,
    Listing,
    names_of,
    read_info,
    read_listing,
    read_tasks,
    reward_in,
    seen_in,
    shapes_of,
    version_of,
)

MOST_BYTES = 2**35
GROUP_BYTES = 2**30
"""The most bytes of a group of rows, unpacked."""
LABEL, PAY = f"{BEHAVIOUR}{SUCCESS}", f"{REWARD}{RECORDED}"
NUMBERS = {"episode": EPISODE, "step": FRAME}


@dataclass(frozen=True)
class LeRobot:
    """Episodes as LeRobot lays them out in a folder, versions 2.0, 2.1 and 3.0.

    Attributes:
        success: Where success stands, in a column or in the list of episodes, also ``KEY>0.5``; found by its name if
            empty.
        cluster: The column, or the key of an episode, that says who made it; found by its name if empty.
        partial: Whether less than the metadata declares may be there.
    """

    success: str = ""
    cluster: str = ""
    partial: bool = False
    takes_all: ClassVar[bool] = True
    takes_names: ClassVar[bool] = True

    def recognises(self, path: Path, head: bytes) -> bool:
        """A folder with the metadata."""
        return (path / INFO_FILE).is_file()

    def read(self, path: Path) -> tuple[Log, ...]:
        """The data set; its steps are read later."""
        folder = path.expanduser()
        place = folder / INFO_FILE
        if not place.is_file():
            raise UsageError(f"No LeRobot data set at '{path}': name its folder, which holds {INFO_FILE}")
        with reading(place, "LeRobot data set"):
            info = read_info(place)
            version = version_of(place, info)
            features = info["features"]
            shapes = shapes_of(place, features)
            taken = (reward_in(shapes), *NEEDED, STATE, NEXT_STATE)
            own = own_rewards(place, info.get(OWN_REWARDS), shapes, taken)
            listing, tasks = read_listing(folder), read_tasks(folder)
            files, notes = _files(folder, info, listing)
        census = _census(folder, files, shapes, listing, info, self.partial)
        told = (*_other(shapes), *listing.keys)
        usual = [f"{begin}{key}" for key in SUCCESS_KEYS for begin in ("next.", "")]
        rule = success_rule(self.success, told, folder, usual)
        facts = DatasetFacts(
            path=folder,
            format=f"LeRobot v{'.'.join(map(str, version))}",
            name=f"lerobot:{path}",
            env=shortened(str(info.get("robot_type") or ""), 200),
            declared={"tasks": count} if (count := whole(info.get("total_tasks"))) is not None else {},
            names={OBSERVATION: names_of(features, STATE), ACTION: names_of(features, ACTION)},
            success="" if rule is None else rule.text,
            told_by="" if rule is None else {reward_in(shapes): RECORDED, **own}.get(rule.key, ""),
            operator=operator_key(self.cluster, told, folder),
            task=TASK_INDEX if TASK_INDEX in shapes else TASKS if TASKS in listing.keys else "",
            pictures_left_out=any(name.startswith(SEEN_BEGIN) and name not in shapes for name in features),
            notes=(*notes, *_notes_on_seen(shapes), *census.notes),
        )
        layout = _Layout(facts, files, shapes, own, listing, tasks, census.episodes, rule)
        return (Log(facts, tuple(layout.columns()), partial(_tables, layout)),)

    def write_example(self, folder: Path) -> Path:
        """Two episodes, of the layout of version 2.1."""
        lengths = (3, 4)
        (folder / "meta").mkdir()
        (folder / "data/chunk-000").mkdir(parents=True)
        kinds = {STATE: ("float32", 2), ACTION: ("float32", 1), "next.reward": ("float32", 1),
                 "next.success": ("bool", 1), EPISODE: ("int64", 1), FRAME: ("int64", 1)}  # fmt: skip
        features = {name: {"dtype": kind, "shape": [size], "names": None} for name, (kind, size) in kinds.items()}
        told = {"codebase_version": "v2.1", "total_episodes": 2, "total_frames": 7, "features": features}
        (folder / INFO_FILE).write_text(json.dumps(told))
        for number, steps in enumerate(lengths):
            columns = {
                STATE: list(np.arange(2 * steps, dtype=np.float32).reshape(steps, 2)),
                ACTION: list(np.linspace(-1.0, 1.0, steps, dtype=np.float32)[:, None]),
                "next.reward": -np.arange(1, steps + 1, dtype=np.float32),
                "next.success": np.arange(1, steps + 1) == steps * number,
                EPISODE: np.full(steps, number),
                FRAME: np.arange(steps),
            }
            pq.write_table(pa.table(columns), folder / f"data/chunk-000/episode_{number:06d}.parquet")
        return folder


class _Layout(NamedTuple):
    """What is read of each file, and what is known of each episode."""

    facts: DatasetFacts
    files: tuple[Path, ...]
    shapes: Mapping[str, tuple[int, ...]]
    own: Mapping[str, str]
    listing: Listing
    tasks: Mapping[int, str]
    episodes: frozenset[int]
    rule: SuccessRule | None

    @property
    def seen(self) -> dict[str, str]:
        """By column of an observation, what the file calls it."""
        found = seen_in(self.shapes)
        return {OBSERVATION if it == STATE else f"{OBSERVATION}/{it.removeprefix(SEEN_BEGIN)}": it for it in found}

    @property
    def plain(self) -> dict[str, str]:
        """By column, what the file calls it, where nothing has to be done to it."""
        pay = {PAY: reward} if (reward := reward_in(self.shapes)) else {}
        pay |= {f"{REWARD}{name}": key for key, name in self.own.items()}
        infos = {f"{INFO}{key}": key for key in _other(self.shapes) if key not in self.own}
        return {**NUMBERS, **pay, ACTION: ACTION, **{f"{BEFORE}{name}": it for name, it in self.seen.items()}, **infos}

    @property
    def sees_last(self) -> bool:
        """Whether it is known what was seen after the last frame of an episode."""
        return {STATE, NEXT_STATE} <= {*self.shapes}

    def columns(self) -> Iterator[str]:
        """All columns of the log."""
        yield from (*self.plain, *self.seen, FILE_COLUMN)
        yield from [SEEN] if self.seen and not self.sees_last else []
        yield from [LABEL] if self.rule is not None else []
        yield from [OPERATOR] if self.facts.operator else []
        yield from [TASK] if self.facts.task else []

    def needed(self, names: tuple[str, ...]) -> dict[str, tuple[int, ...]]:
        """What has to be read of the files for some columns, with its shape."""
        sources = {*NUMBERS.values(), DONE, *(it for name, it in {**self.plain, **self.seen}.items() if name in names)}
        sources |= {NEXT_STATE} if OBSERVATION in names else set()
        sources |= {self.rule.key} if self.rule is not None and LABEL in names else set()
        sources |= {self.facts.operator} if OPERATOR in names else set()
        sources |= {self.facts.task} if TASK in names else set()
        return {name: shape for name, shape in self.shapes.items() if name in sources}


def _other(shapes: Mapping[str, Any]) -> list[str]:
    """Columns that are told beside what was seen and done."""
    return [name for name in shapes if name not in (*seen_in(shapes), ACTION, NEXT_STATE)]


def _notes_on_seen(shapes: Mapping[str, Any]) -> list[str]:
    if STATE in shapes:
        return []
    parts = ", ".join(name.removeprefix(SEEN_BEGIN) for name in seen_in(shapes))
    found = f"an observation is a dictionary of {parts}" if parts else NOTHING_SEEN
    return [f"There are no numbers of {STATE}: {found}"]


def _files(folder: Path, info: Mapping[str, Any], listing: Listing) -> tuple[tuple[Path, ...], list[str]]:
    """The files of frames, and what is told of those that are left out. Since v3.0 the list of episodes names them."""
    found = sorted((folder / "data").glob("*/*.parquet"))
    if len(found) > MOST_FILES:
        raise SchemaError(f"{folder} has {len(found):,} files, {MOST_FILES:,} are allowed")
    if {CHUNK, FILE} <= {*listing.keys} and info.get("data_path", DATA_PATH) == DATA_PATH:
        rows = listing.rows.values()
        numbers = [whole(row.get(key)) for row in rows for key in (CHUNK, FILE)]
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


class _Frames(NamedTuple):
    """Consecutive rows of a file: what it holds, and what was read before them."""

    columns: dict[str, NDArray[Any]]
    files: NDArray[Any]

    def __len__(self) -> int:
        return len(self.files)

    def part(self, rows: slice | Mask) -> "_Frames":
        """Some of them."""
        return _Frames({name: values[rows] for name, values in self.columns.items()}, self.files[rows])

    def joined(self, other: "_Frames") -> "_Frames":
        """With those that follow."""
        columns = {name: np.concatenate([values, other.columns[name]]) for name, values in self.columns.items()}
        return _Frames(columns, np.concatenate([self.files, other.files]))


def _tables(layout: _Layout, names: tuple[str, ...]) -> Iterator[Mapping[str, NDArray[Any]]]:
    """The last frame that was read waits for the next one, which may be what was seen after it."""
    waiting: _Frames | None = None
    begun: set[int] = set()
    last = layout.files[-1]
    for path in layout.files:
        with reading(path, "LeRobot data set"):
            for frames in _read_file(layout, path, names):
                _require_order(layout.facts.path / frames.files[0], waiting, frames, begun)
                whole = frames if waiting is None else waiting.joined(frames)
                waiting = whole.part(slice(len(whole) - 1, None))
                yield from _rows(layout, whole, len(whole) - 1, names)
    if waiting is not None:
        with reading(last, "LeRobot data set"):
            yield from _rows(layout, waiting, 1, names)


def _read_file(layout: _Layout, path: Path, names: tuple[str, ...]) -> Iterator[_Frames]:
    needed = layout.needed(names)
    rows = max(2, rows_at_once(8 * sum(math.prod(shape) for shape in needed.values())))
    file, first = path.relative_to(layout.facts.path).as_posix(), 0
    with pq.ParquetFile(path) as parquet:
        for batch in parquet.iter_batches(rows, columns=list(needed)):
            if batch.num_rows:
                columns = {name: _array(path, batch, name, shape, first) for name, shape in needed.items()}
                yield _Frames(columns, texts(file, batch.num_rows))
            first += batch.num_rows


def _require_order(path: Path, before: _Frames | None, frames: _Frames, begun: set[int]) -> None:
    """See that frames follow one another, each episode from 0 on and in one place.

    Raises:
        SchemaError: They do not, or an episode that had ended goes on: several stand there as one.
    """
    whole = frames if before is None else before.joined(frames)
    episode, frame = whole.columns[EPISODE], whole.columns[FRAME].astype(np.int64)
    same = episode[1:] == episode[:-1]
    starts = np.flatnonzero(~same) + 1 if before is not None else np.concatenate([[0], np.flatnonzero(~same) + 1])
    numbers = episode[starts].tolist()
    odd = [
        *np.flatnonzero(same & (np.diff(frame) != 1)) + 1,
        *starts[frame[starts] != 0],
        *(place for place, number in zip(starts, numbers, strict=True) if number in begun),
    ]
    if odd or len({*numbers}) < len(numbers):
        number = int(episode[odd[0]]) if odd else numbers[0]
        raise SchemaError(
            f"{path}, episode {number}: its frames do not follow one another, from 0 on. Sort the rows by {EPISODE} "
            f"and {FRAME}"
        )
    begun.update(numbers)
    if DONE not in whole.columns:
        return
    done = whole.columns[DONE].astype(bool).ravel()
    if len(goes_on := np.flatnonzero(same & done[:-1] & ~done[1:])):
        row = int(goes_on[0])
        raise SchemaError(
            f"{path}, episode {episode[row]}: {DONE} ends it with frame {frame[row]}, and it goes on with frame "
            f"{frame[row + 1]}: several episodes are stored as one. Record them anew, each with its own {EPISODE}"
        )


def _rows(layout: _Layout, whole: _Frames, count: int, names: tuple[str, ...]) -> Iterator[Mapping[str, NDArray[Any]]]:
    """The first rows of some frames, without those that do not belong to the data set."""
    episode = whole.columns[EPISODE]
    seen = np.zeros(count, bool)
    seen[: len(whole) - 1] = episode[1 : count + 1] == episode[: len(whole) - 1][:count]
    belongs = np.isin(episode[:count], list(layout.episodes))
    if not belongs.any():
        return
    frames = whole.part(slice(0, count))
    table = {name: _column(layout, name, frames, whole, seen) for name in names}
    yield table if belongs.all() else {name: values[belongs] for name, values in table.items()}


def _column(layout: _Layout, name: str, frames: _Frames, whole: _Frames, seen: Mask) -> NDArray[Any]:
    described = {OPERATOR: _operators, TASK: _tasks}
    if name in described:
        return described[name](layout, frames)
    known = {SEEN: seen, FILE_COLUMN: frames.files}
    if name in known:
        return known[name]
    if name == LABEL:
        return _success(layout, frames, seen)
    if name in layout.seen:
        return _after(layout, layout.seen[name], frames, whole, seen)
    values = frames.columns[layout.plain[name]]
    if name == "step":
        return values.astype(np.int64) + 1
    return np.asarray(values, np.float64).ravel() if name.startswith(REWARD) else values


def _after(layout: _Layout, key: str, frames: _Frames, whole: _Frames, seen: Mask) -> NDArray[Any]:
    """What was seen after each frame: what the next one of its episode holds."""
    after = whole.columns[key][np.minimum(np.arange(len(frames)) + 1, len(whole) - 1)]
    if layout.sees_last:
        return np.where(seen.reshape(-1, *[1] * (after.ndim - 1)), after, frames.columns[NEXT_STATE])
    return where_seen(after, seen)


def _success(layout: _Layout, frames: _Frames, seen: Mask) -> Float:
    """Labels of each step; what is said of a whole episode stands in its last one."""
    rule, numbers = layout.rule, frames.columns[EPISODE]
    assert rule is not None  # or there is no such column
    where = f"{layout.facts.path / frames.files[0]}, from episode {numbers[0]} on"
    if rule.key in layout.shapes:
        return as_measure(rule.of_steps(frames.columns[rule.key], f"{where}: {rule.key}"))
    told = np.full(len(frames), UNKNOWN, np.int8)
    for row in np.flatnonzero(~seen):
        number = int(numbers[row])
        noun = f"{layout.listing.path}, episode {number}: {rule.key}"
        told[row] = rule.of_episode(layout.listing.value(number, rule.key), noun)
    return as_measure(told)


def _by_number(numbers: NDArray[Any], text: Mapping[int, str]) -> NDArray[Any]:
    """A text for each row, by a number in it."""
    found, place = np.unique(numbers.ravel(), return_inverse=True)
    return np.array([text[int(number)] for number in found], object)[place]


def _operators(layout: _Layout, frames: _Frames) -> NDArray[Any]:
    key, numbers = layout.facts.operator, frames.columns[EPISODE]
    if key in layout.shapes:
        return as_texts(frames.columns[key])
    told = {number: layout.listing.value(number, key) for number in np.unique(numbers).tolist()}
    return _by_number(numbers, {it: "" if who is None else shortened(str(who), 200) for it, who in told.items()})


def _tasks(layout: _Layout, frames: _Frames) -> NDArray[Any]:
    if layout.facts.task == TASK_INDEX:
        numbers = frames.columns[TASK_INDEX]
        return _by_number(numbers, {it: layout.tasks.get(it, str(it)) for it in np.unique(numbers).tolist()})
    numbers = frames.columns[EPISODE]
    told = {number: layout.listing.value(number, TASKS) for number in np.unique(numbers).tolist()}
    joined = {it: " + ".join(map(str, of)) if isinstance(of, list) else str(of or "") for it, of in told.items()}
    return _by_number(numbers, {it: shortened(text, 200) for it, text in joined.items()})


def _require_columns(path: Path, file: pq.ParquetFile, shapes: Mapping[str, Any]) -> None:
    missing = [name for name in shapes if name not in file.schema_arrow.names]
    if missing:
        raise SchemaError(f"{path} has no column {', '.join(missing)}, of which {INFO_FILE} tells")
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
    noun = f"{path}: {name} has gaps, or other rows than the {list(shape)} that {INFO_FILE} tells"
    for level, size in enumerate(_sizes(column.type, shape, noun)):
        lengths = pc.fill_null(pc.list_value_length(column), -1).to_numpy(zero_copy_only=False)
        odd = np.flatnonzero(lengths != size)
        if len(odd):
            raise SchemaError(f"{noun}; the first is row {first + int(odd[0]) // math.prod(shape[:level])}")
        column = column.flatten()
    if isinstance(column, pa.ExtensionArray):
        raise SchemaError(f"{path}: {name} is of the type {column.type}, not of lists of numbers")
    if column.null_count and name in (EPISODE, FRAME, TASK_INDEX):
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
