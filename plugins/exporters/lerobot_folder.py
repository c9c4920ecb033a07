"""Episodes as a LeRobot data set, version 3.0 of the layout, written by pyarrow alone. Its numbers are float32."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from harness.arrays import Float
from harness.text import file_stems

from ..datasets.dataset import OPERATOR_KEYS, OWN_REWARDS
from ..datasets.lerobot_facts import ACTION, DATA_PATH, INFO_FILE, NEXT_STATE, REWARD, STATE
from .episodes import TERMS, Exported, Source, Term

VERSION = "v3.0"
FILE = DATA_PATH.removeprefix("data/")
FILE_ROWS, GROUP_ROWS = 2_000_000, 65_536
"""Rows of a file, and of a group in it, at least; no episode lies in two files."""
CHUNK_FILES = 1_000
TASK = "reach"
INTEGERS = ("frame_index", "episode_index", "index", "task_index")


def write_lerobot(source: Source, folder: Path) -> int:
    """Write a data set into a folder of its own; how many episodes it has.

    A frame has what was seen before a step (``observation.state``), what was done (``action``), and what came of it:
    ``next.observation.state``, ``next.reward`` (what the learner was paid), ``next.done``, ``next.success``,
    ``next.reward_...`` for each reward, and ``next.reward_term_...`` for each term of one. The list of episodes says of
    each whose policy acted, as ``operator``.

    Raises:
        OSError: The folder cannot be written.
        UsageError: An env cannot be made again.
    """
    stems = file_stems(source.rewards)
    columns = {label: f"{REWARD}_{stem}" for label, stem in zip(source.rewards, stems, strict=True)}
    named = zip(source.terms, file_stems([it.title for it in source.terms]), strict=True)
    terms = {term: f"{REWARD}_term_{stem}" for term, stem in named}
    (folder / INFO_FILE).parent.mkdir(parents=True)
    frames = _Frames(folder)
    for number, episode in enumerate(source.episodes()):
        frames.operators.append(episode.operator)
        frames.append(_table(number, frames.rows, episode, columns, terms, source.period))
    frames.close()
    _write_tables(folder, frames)
    _write_info(folder, source, frames, columns, terms)
    return len(frames.lengths)


class _Frames:
    """Writes the tables of episodes into files, and counts."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._waiting: list[pa.Table] = []
        self._writer: pq.ParquetWriter | None = None
        self._in_file = 0
        self.file = 0
        self.rows = 0
        self.lengths: list[int] = []
        self.files: list[int] = []
        self.operators: list[str] = []
        self.schema: pa.Schema | None = None
        self.sums: dict[str, list[Float]] = {}

    def append(self, table: pa.Table) -> None:
        if self._in_file >= FILE_ROWS:
            self._finish()
            self.file += 1
        self.schema = table.schema
        self._waiting.append(table)
        self.lengths.append(table.num_rows)
        self.files.append(self.file)
        self.rows += table.num_rows
        self._in_file += table.num_rows
        self._count(table)
        if sum(it.num_rows for it in self._waiting) >= GROUP_ROWS:
            self._flush()

    def close(self) -> None:
        self._finish()

    def _flush(self) -> None:
        if not self._waiting:
            return
        table = pa.concat_tables(self._waiting)
        if self._writer is None:
            path = self._folder / "data" / _file(self.file)
            path.parent.mkdir(parents=True, exist_ok=True)
            self._writer = pq.ParquetWriter(path, table.schema, compression="zstd")
        self._writer.write_table(table)
        self._waiting = []

    def _finish(self) -> None:
        self._flush()
        if self._writer is not None:
            self._writer.close()
        self._writer, self._in_file = None, 0

    def _count(self, table: pa.Table) -> None:
        """Keep what statistics are made of: least, greatest, sum and sum of squares."""
        for name in table.column_names:
            values = _rows_of(table.column(name))
            now = [values.min(0), values.max(0), values.sum(0), np.square(values).sum(0)]
            known = self.sums.setdefault(name, now)
            if known is not now:
                least, greatest = np.minimum(known[0], now[0]), np.maximum(known[1], now[1])
                self.sums[name] = [least, greatest, known[2] + now[2], known[3] + now[3]]


def _file(number: int) -> str:
    return FILE.format(chunk_index=number // CHUNK_FILES, file_index=number % CHUNK_FILES)


def _rows_of(column: pa.ChunkedArray) -> Float:
    whole = column.combine_chunks()
    if pa.types.is_fixed_size_list(whole.type):
        return np.asarray(whole.flatten(), np.float64).reshape(len(whole), whole.type.list_size)
    return np.asarray(whole.to_numpy(zero_copy_only=False), np.float64).reshape(len(whole), 1)


def _table(
    number: int,
    begin: int,
    episode: Exported,
    columns: Mapping[str, str],
    terms: Mapping[Term, str],
    period: float,
) -> pa.Table:
    steps = len(episode.rewards)
    state = _flat(episode.observations)
    frame = np.arange(steps)
    told: dict[str, Any] = {
        STATE: _list(state[:-1]),
        ACTION: _list(_flat(episode.actions)),
        NEXT_STATE: _list(state[1:]),
        REWARD: episode.rewards.astype(np.float32),
        **{columns[label]: values.astype(np.float32) for label, values in episode.paid.items()},
        **{terms[term]: values.astype(np.float32) for term, values in episode.terms.items()},
        "next.done": episode.terminated | episode.truncated,
    }
    if episode.success is not None:
        told["next.success"] = np.asarray(episode.success, bool)
    told |= {f"next.{key}": values.astype(np.float32) for key, values in episode.infos.items() if key != "success"}
    told |= {
        "timestamp": (frame * period).astype(np.float32),
        "frame_index": frame,
        "episode_index": np.full(steps, number),
        "index": begin + frame,
        "task_index": np.zeros(steps, np.int64),
    }
    return pa.table(told)


def _flat(rows: Any) -> NDArray[np.float32]:
    """All numbers of each row, float32."""
    if isinstance(rows, dict | tuple):
        return np.concatenate([_flat(part) for part in (rows.values() if isinstance(rows, dict) else rows)], axis=1)
    return np.asarray(rows, np.float32).reshape(len(rows), -1)


def _list(rows: NDArray[np.float32]) -> pa.FixedSizeListArray:
    return pa.FixedSizeListArray.from_arrays(np.ascontiguousarray(rows).ravel(), rows.shape[1])


def _write_tables(folder: Path, frames: _Frames) -> None:
    """Write which episode lies where, and the one task, named as pandas names rows."""
    ends = np.cumsum(frames.lengths, dtype=np.int64)
    count = len(frames.lengths)
    files = np.array(frames.files, np.int64)
    episodes = pa.table(
        {
            "episode_index": np.arange(count),
            "tasks": pa.array([[TASK]] * count, pa.list_(pa.string())),
            "length": np.array(frames.lengths, np.int64),
            OPERATOR_KEYS[0]: pa.array(frames.operators, pa.string()),
            "data/chunk_index": files // CHUNK_FILES,
            "data/file_index": files % CHUNK_FILES,
            "dataset_from_index": ends - np.array(frames.lengths, np.int64),
            "dataset_to_index": ends,
            "meta/episodes/chunk_index": np.zeros(count, np.int64),
            "meta/episodes/file_index": np.zeros(count, np.int64),
        }
    )
    place = folder / "meta" / "episodes" / _file(0)
    place.parent.mkdir(parents=True)
    pq.write_table(episodes, place)
    index = "__index_level_0__"
    pandas: dict[str, Any] = {
        "index_columns": [index],
        "column_indexes": [],
        "columns": [
            {"name": "task_index", "pandas_type": "int64", "numpy_type": "int64", "metadata": None},
            {"name": None, "pandas_type": "unicode", "numpy_type": "object", "metadata": None},
        ],
        "pandas_version": "2",
    }
    for column, name in zip(pandas["columns"], ("task_index", index), strict=True):
        column["field_name"] = name
    tasks = pa.table({"task_index": np.zeros(1, np.int64), index: [TASK]})
    pq.write_table(tasks.replace_schema_metadata({"pandas": json.dumps(pandas)}), folder / "meta" / "tasks.parquet")
    (folder / "meta" / "stats.json").write_text(json.dumps(dict(_stats(frames)), indent=1), encoding="utf-8")


def _stats(frames: _Frames) -> Iterator[tuple[str, dict[str, Any]]]:
    for name, (least, greatest, total, squares) in frames.sums.items():
        mean = total / frames.rows
        spread = np.sqrt(np.maximum(squares / frames.rows - np.square(mean), 0.0))
        told = {"min": least, "max": greatest, "mean": mean, "std": spread}
        yield name, {**{key: values.tolist() for key, values in told.items()}, "count": [frames.rows]}


def _write_info(
    folder: Path, source: Source, frames: _Frames, columns: Mapping[str, str], terms: Mapping[Term, str]
) -> None:
    data = DATA_PATH
    told = {
        "codebase_version": VERSION,
        "robot_type": source.robot,
        "total_episodes": len(frames.lengths),
        "total_frames": frames.rows,
        "total_tasks": 1,
        "chunks_size": CHUNK_FILES,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 500,
        "fps": max(1, round(1.0 / source.period)),
        "splits": {"train": f"0:{len(frames.lengths)}"},
        "data_path": data,
        "video_path": None,
        "features": dict(_features(source, frames)),
        OWN_REWARDS: {column: label for label, column in columns.items()},
        **({TERMS: {column: term.title for term, column in terms.items()}} if terms else {}),
    }
    (folder / INFO_FILE).write_text(json.dumps(told, indent=1), encoding="utf-8")


def _features(source: Source, frames: _Frames) -> Iterator[tuple[str, dict[str, Any]]]:
    for field in frames.schema or ():
        width = field.type.list_size if pa.types.is_fixed_size_list(field.type) else 1
        kind = "bool" if pa.types.is_boolean(field.type) else "int64" if field.name in INTEGERS else "float32"
        named = source.names.get("action" if field.name == ACTION else "observation", ())
        names = list(named) if field.name in (STATE, ACTION, NEXT_STATE) and len(named) == width else None
        yield field.name, {"dtype": kind, "shape": [width], "names": names}
