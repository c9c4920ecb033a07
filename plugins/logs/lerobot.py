"""A LeRobot data set: a folder of JSON and Parquet files, read by pyarrow alone; its videos are left out.

A frame holds what was seen and what was done then, and under names that begin with ``next.`` what came of it. What was
seen after the last frame of an episode is not recorded: its pay and its success count, but no function can look at what
came next.
"""

import json
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from numpy.typing import NDArray

from harness import Ints
from harness.errors import SchemaError, UsageError, one_line
from harness.files import open_regular, reading
from harness.log import DatasetFacts, Log

from ..datasets.dataset import (
    NOTHING_SEEN,
    SUCCESS_KEYS,
    require_readable,
    rows_at_once,
    take_census,
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
from ..datasets.steps import Source, Steps, as_texts, source_of

MOST_BYTES = 2**35
GROUP_BYTES = 2**30
"""The most bytes of a group of rows, unpacked."""


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
            listing, tasks = read_listing(folder), read_tasks(folder)
            files, notes = _files(folder, info, listing)
            told = {number: whole(row.get("length")) for number, row in listing.rows.items()}
            belonging, gaps = take_census(
                folder,
                _lengths(folder, files, shapes),
                partial=self.partial,
                episodes=whole(info.get("total_episodes")),
                steps=whole(info.get("total_frames")),
                listed=told,
                lengths={number: length for number, length in told.items() if length is not None},
            )
        reward, seen = reward_in(shapes), seen_in(shapes)
        other = [name for name in shapes if name not in (*seen, "action")]
        keys = (*other, *listing.keys)
        facts = DatasetFacts(
            path=folder,
            format=f"LeRobot v{'.'.join(map(str, version))}",
            name=f"lerobot:{path}",
            env=one_line(str(info.get("robot_type") or ""), 200),
            declared={"tasks": count} if (count := whole(info.get("total_tasks"))) is not None else {},
            names={"observation": names_of(features, shapes, STATE), "action": names_of(features, shapes, "action")},
            task=TASK_INDEX if TASK_INDEX in shapes else TASKS if TASKS in listing.keys else "",
            pictures_left_out=any(name.startswith(SEEN_BEGIN) and name not in shapes for name in features),
            notes=(*notes, *_notes_on_seen(seen), *gaps),
        )
        usual = [f"{begin}{key}" for key in SUCCESS_KEYS for begin in ("next.", "")]
        source = source_of(facts, self.success, self.cluster, keys, reward=reward, usual=usual, sees_last=not seen)
        places = {"episode": EPISODE, "step": FRAME, "reward/recorded": reward, "action": "action"}
        places |= {f"info/{key}": key for key in other}
        parts = {key: "observation" if key == STATE else f"observation/{key.removeprefix(SEEN_BEGIN)}" for key in seen}
        places |= {f"{begin}{part}": key for key, part in parts.items() for begin in ("before/", "")}
        columns = (*(name for name, key in places.items() if key), "file")
        places = {name: key for name, key in {**places, **source.keys}.items() if key in shapes}
        layout = _Layout(source, files, shapes, places, listing, tasks, np.array([*belonging], np.int64))
        return (source.log(columns, partial(_tables, layout)),)

    def write_example(self, folder: Path) -> Path:
        """Two episodes, of the layout of version 2.1."""
        (folder / "meta").mkdir()
        (folder / "data/chunk-000").mkdir(parents=True)
        for number, steps in enumerate((3, 4)):
            columns = {
                STATE: np.arange(2.0 * steps).reshape(steps, 2),
                "action": np.linspace(-1.0, 1.0, steps)[:, None],
                "next.reward": -np.arange(1.0, steps + 1),
                "next.success": np.arange(1, steps + 1) == steps * number,
                EPISODE: np.full(steps, number),
                FRAME: np.arange(steps),
            }
            table = pa.table({name: values.tolist() for name, values in columns.items()})
            pq.write_table(table, folder / f"data/chunk-000/episode_{number:06d}.parquet")
        features = {name: {"dtype": str(of.dtype), "shape": of.shape[1:] or [1]} for name, of in columns.items()}
        told = {"codebase_version": "v2.1", "total_episodes": 2, "total_frames": 7, "features": features}
        (folder / INFO_FILE).write_text(json.dumps(told))
        return folder


class _Layout(NamedTuple):
    """What is read of each file, and what is known of each episode.

    Attributes:
        source: What is known of the data set.
        files: Of frames.
        shapes: Of the rows of each of their columns.
        places: By column of the log, that of the files.
        listing: What is told of each episode.
        tasks: Names of the tasks, by number.
        episodes: Numbers of those that are read.
    """

    source: Source
    files: tuple[Path, ...]
    shapes: Mapping[str, tuple[int, ...]]
    places: Mapping[str, str]
    listing: Listing
    tasks: Mapping[int, str]
    episodes: Ints

    def told(self, number: int, key: str) -> Any:
        """What is told of an episode."""
        value = self.listing.rows.get(number, {}).get(key)
        return " + ".join(map(str, value)) if isinstance(value, list) else value


def _notes_on_seen(seen: Sequence[str]) -> list[str]:
    if STATE in seen:
        return []
    parts = ", ".join(name.removeprefix(SEEN_BEGIN) for name in seen)
    found = f"an observation is a dictionary of {parts}" if parts else NOTHING_SEEN
    return [f"There are no numbers of {STATE}: {found}"]


def _files(folder: Path, info: Mapping[str, Any], listing: Listing) -> tuple[tuple[Path, ...], list[str]]:
    """The files of frames, and what is told of those that are left out. Since v3.0 the list of episodes names them."""
    found = sorted((folder / "data").glob("*/*.parquet"))
    if len(found) > MOST_FILES:
        raise SchemaError(f"{folder} has {len(found):,} files, {MOST_FILES:,} are allowed")
    named = {*found}
    if {CHUNK, FILE} <= {*listing.keys} and info.get("data_path", DATA_PATH) == DATA_PATH:
        places = {(whole(row.get(CHUNK)), whole(row.get(FILE))) for row in listing.rows.values()}
        if any(number is None or number >= MOST_FILES for place in places for number in place):
            raise SchemaError(f"{listing.path} names a file by {CHUNK} and {FILE} that are no numbers of files")
        named = {folder / DATA_PATH.format(chunk_index=chunk, file_index=file) for chunk, file in places}
    files = tuple(path for path in found if path in named)
    if not files:
        raise SchemaError(f"{folder} has no file data/*/*.parquet that belongs to it")
    beside = [path.relative_to(folder).as_posix() for path in found if path not in named]
    told = f"Left out, since no episode stands in them: {len(beside):,} files ({', '.join(beside[:3])})"
    return files, [told] if beside else []


def _lengths(folder: Path, files: tuple[Path, ...], shapes: Mapping[str, tuple[int, ...]]) -> Mapping[int, int]:
    """How many frames each episode has, which takes one column."""
    found = Counter[int]()
    width, total = sum(math.prod(shape) for shape in shapes.values()), 0
    for path in files:
        with reading(path, "LeRobot data set"), open_regular(path, MOST_BYTES), pq.ParquetFile(path) as file:
            if missing := [name for name in shapes if name not in file.schema_arrow.names]:
                raise SchemaError(f"{path} has no column {', '.join(missing)}, of which {INFO_FILE} tells")
            groups = map(file.metadata.row_group, range(file.metadata.num_row_groups))
            if any(group.total_byte_size > GROUP_BYTES for group in groups):
                raise SchemaError(f"{path} has a group of rows of more than {GROUP_BYTES:,} bytes")
            total += file.metadata.num_rows
            require_readable(folder, total, width)
            for batch in file.iter_batches(columns=[EPISODE]):
                found.update(_array(path, batch, EPISODE, (1,), 0).astype(np.int64).tolist())
    return found


Frames = dict[str, NDArray[Any]]
"""Consecutive rows of files, by column."""


def _tables(layout: _Layout, names: tuple[str, ...]) -> Iterator[Frames]:
    """The last frame that was read waits for the next one, which may be what was seen after it."""
    waiting: Frames = {}
    begun: set[int] = set()
    for path in layout.files:
        with reading(path, "LeRobot data set"):
            for read in _read_file(layout, path, names):
                frames = {name: np.concatenate([waiting.get(name, of[:0]), of]) for name, of in read.items()}
                _require_order(path, frames, begun, goes_on=bool(waiting))
                waiting = {name: values[-1:] for name, values in frames.items()}
                yield from _rows(layout, frames, len(frames[EPISODE]) - 1, names)
    if waiting:
        yield from _rows(layout, waiting, 1, names)


def _read_file(layout: _Layout, path: Path, names: tuple[str, ...]) -> Iterator[Frames]:
    asked = {EPISODE, FRAME, DONE, *(key for name, key in layout.places.items() if name in names)}
    needed = {name: shape for name, shape in layout.shapes.items() if name in asked}
    rows = max(2, rows_at_once(8 * sum(math.prod(shape) for shape in needed.values())))
    file, first = path.relative_to(layout.source.facts.path).as_posix(), 0
    with pq.ParquetFile(path) as parquet:
        for batch in parquet.iter_batches(rows, columns=list(needed)):
            columns = {name: _array(path, batch, name, shape, first) for name, shape in needed.items()}
            columns |= {name: columns[name].astype(np.int64) for name in (EPISODE, FRAME)}
            if batch.num_rows:
                yield {**columns, "file": np.full(batch.num_rows, file, object)}
            first += batch.num_rows


def _require_order(path: Path, frames: Frames, begun: set[int], *, goes_on: bool) -> None:
    """See that frames follow one another, each episode from 0 on and in one place.

    Args:
        path: Their file.
        frames: Some of it.
        begun: Numbers of the episodes that have begun before; these are added.
        goes_on: Whether the first frame was looked at before.

    Raises:
        SchemaError: They do not, or an episode that had ended goes on: several stand there as one.
    """
    episode, frame = frames[EPISODE], frames[FRAME]
    begins = np.concatenate([[not goes_on], episode[1:] != episode[:-1]])
    follows = np.where(begins, frame == 0, np.diff(frame, prepend=frame[:1] - 1) == 1)
    wrong = episode[~follows].tolist()
    for number in episode[begins].tolist():
        wrong += [number] * (number in begun)
        begun.add(number)
    if wrong:
        raise SchemaError(
            f"{path}, episode {wrong[0]}: its frames do not follow one another, from 0 on. Sort the rows by {EPISODE} "
            f"and {FRAME}"
        )
    done = frames[DONE].astype(bool).ravel() if DONE in frames else np.zeros(len(frame), bool)
    if len(ended := np.flatnonzero(~begins[1:] & done[:-1] & ~done[1:])):
        row = int(ended[0])
        raise SchemaError(
            f"{path}, episode {episode[row]}: {DONE} ends it with frame {frame[row]}, and it goes on with frame "
            f"{frame[row + 1]}: several episodes are stored as one. Record them anew, each with its own {EPISODE}"
        )


def _rows(layout: _Layout, frames: Frames, count: int, names: tuple[str, ...]) -> Iterator[Frames]:
    """The first rows of some frames, without those that do not belong to the data set."""
    episode = frames[EPISODE]
    rows = np.flatnonzero(np.isin(episode[:count], layout.episodes))
    if not len(rows):
        return
    ends, following = np.append(episode[1:] != episode[:-1], True), np.minimum(rows + 1, len(episode) - 1)
    table = {"file": frames["file"][rows]}
    for name, key in layout.places.items():
        if name in names:
            table[name] = frames[key][following if name.startswith("observation") else rows]
    if "step" in table:
        table["step"] = table["step"] + 1
    if "task" in table:
        table["task"] = as_texts(table["task"], lambda number: layout.tasks.get(int(number), str(number)))
    where = f"{layout.source.facts.path / table['file'][0]}, from episode {episode[rows[0]]} on"
    yield layout.source.columns(names, Steps(table, episode[rows], ends[rows], where), layout.told)


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
    depth = str(column.type).count("list<")  # of one length or of any, lists in lists for each number of the shape
    for level, size in enumerate({len(shape): shape, 1: (math.prod(shape),)}.get(depth, ())):
        lengths = pc.fill_null(pc.list_value_length(column), -1).to_numpy(zero_copy_only=False)
        odd = np.flatnonzero(lengths != size)
        if len(odd):
            raise SchemaError(f"{noun}; the first is row {first + int(odd[0]) // math.prod(shape[:level])}")
        column = column.flatten()
    if isinstance(column, pa.ExtensionArray):
        raise SchemaError(f"{path}: {name} is of the type {column.type}, not of lists of numbers")
    is_gappy = column.null_count > 0
    if len(column) != batch.num_rows * math.prod(shape) or (is_gappy and name in (EPISODE, FRAME, TASK_INDEX)):
        raise SchemaError(noun)
    if is_gappy:  # what pandas writes for a number that is none
        column = column.cast(pa.float64())
    values = np.asarray(column.to_numpy(zero_copy_only=False))
    if values.dtype.kind not in "biuf":
        raise SchemaError(f"{path}: {name} holds {values.dtype}, no numbers")
    return values if shape == (1,) and name not in (STATE, "action") else values.reshape(batch.num_rows, *shape)
