"""A LeRobot data set: a folder of JSON and Parquet files, read by pyarrow alone; its videos are left out.

A frame holds what was seen and what was done then, and under names that begin with ``next.`` what came of it. What was
seen after the last frame of an episode is not recorded, so that the last step has no next observation and is not paid.
`harness export` writes that too, as ``next.observation.state``, and then no step is lost.
"""

import math
import re
from collections.abc import Iterator, Mapping
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from harness.errors import NewerFormat, SchemaError, UsageError
from harness.files.bounded import read_json, reading, require_regular
from harness.record.dataset.dataset import (
    MOST_KEYS,
    MOST_NUMBERS,
    OPERATOR_KEYS,
    OWN_REWARDS,
    PIECE_BYTES,
    RECORDED,
    ROWS,
    SUCCESS_KEYS,
    Dataset,
    DatasetFacts,
    Piece,
    require_finite,
)
from harness.text import shortened

INFO = Path("meta/info.json")
KNOWN = ((2, 0), (2, 1), (3, 0))
"""Versions of the layout."""
STATE, ACTION, EPISODE, FRAME = "observation.state", "action", "episode_index", "frame_index"
NEXT_STATE, REWARD = f"next.{STATE}", "next.reward"
NEEDED = (STATE, ACTION, EPISODE, FRAME)
MOST_FILES, MOST_BYTES = 1_000_000, 2**35
GROUP_BYTES = 2**30
"""The most bytes of a group of rows, unpacked."""
_VERSION = re.compile(r"v?(\d{1,4})\.(\d{1,4})")


class _Layout(NamedTuple):
    """What is read of each file."""

    files: tuple[Path, ...]
    columns: tuple[str, ...]
    shapes: Mapping[str, tuple[int, ...]]
    own: Mapping[str, str]


def open_lerobot(name: str, success: str = "", cluster: str = "") -> Dataset:
    """A data set; its steps are read later.

    Args:
        name: Its folder.
        success: The column that says whether a step was a success; found by its name if empty.
        cluster: The column that says who made an episode; found by its name if empty.

    Raises:
        UsageError: It is not there.
        NewerFormat: Its layout is of a newer version.
        SchemaError: It is damaged, or lacks a column.
    """
    folder = Path(name).expanduser()
    path = folder / INFO
    if not path.is_file():
        raise UsageError(f"No LeRobot data set at '{name}': name its folder, which holds {INFO}")
    with reading(path, "LeRobot data set"):
        info = _info(path)
        version = _version(path, info)
        features = info["features"]
        layout = _layout(folder, info, features)
    told = _keys(layout)
    known = tuple(f"{begin}{key}" for key in SUCCESS_KEYS for begin in ("next.", ""))
    if success and success not in told:
        raise UsageError(f"--success {success}: {folder} has no such column; it has {', '.join(told)}")
    if cluster and cluster not in told:
        raise UsageError(f"--cluster {cluster}: {folder} has no such column; it has {', '.join(told)}")
    lost = () if NEXT_STATE in layout.columns else ("The last step of each episode has no next observation: left out",)
    facts = DatasetFacts(
        f"lerobot:{name}",
        folder,
        f"LeRobot v{'.'.join(map(str, version))}",
        env=shortened(str(info.get("robot_type") or ""), 200),
        names={"observation": _names(features, STATE), "action": _names(features, ACTION)},
        rewards=(*((RECORDED,) if REWARD in layout.columns else ()), *layout.own.values()),
        success=success or next((key for key in known if key in told), ""),
        operator=cluster or next((key for key in OPERATOR_KEYS if key in told), ""),
        notes=lost,
    )
    return Dataset(facts, partial(_pieces, facts, layout))


def _info(path: Path) -> dict[str, Any]:
    info = read_json(path)
    if not isinstance(info, dict) or not isinstance(info.get("features"), dict):
        raise SchemaError(f"{path} tells of no features")
    if len(info["features"]) > MOST_KEYS or not all(isinstance(it, dict) for it in info["features"].values()):
        raise SchemaError(f"{path} tells of features that are none, or of more than {MOST_KEYS:,}")
    return info


def _version(path: Path, info: Mapping[str, Any]) -> tuple[int, int]:
    told = shortened(str(info.get("codebase_version")), 40)
    found = _VERSION.fullmatch(told)
    version = (int(found[1]), int(found[2])) if found else (0, 0)
    if version in KNOWN:
        return version
    versions = ", ".join(f"v{major}.{minor}" for major, minor in KNOWN)
    if version > KNOWN[-1]:
        raise NewerFormat(f"{path} tells of version {told}, and {versions} are read: it is newer")
    raise SchemaError(f"{path} tells of version {told}, and {versions} are read")


def _layout(folder: Path, info: Mapping[str, Any], features: Mapping[str, Any]) -> _Layout:
    for name in NEEDED:
        if name not in features:
            raise SchemaError(f"{folder / INFO} tells of no column {name}")
    shapes = {name: shape for name, feature in features.items() if (shape := _shape(feature)) is not None}
    for name in NEEDED:
        if name not in shapes:
            raise SchemaError(f"{folder / INFO}: the column {name} holds no numbers, or more than {MOST_NUMBERS:,}")
    found = sorted((folder / "data").glob("*/*.parquet"))
    if not found:
        raise SchemaError(f"{folder} has no file data/*/*.parquet")
    if len(found) > MOST_FILES:
        raise SchemaError(f"{folder} has {len(found):,} files, {MOST_FILES:,} are allowed")
    own = info.get(OWN_REWARDS, {})
    own = own if isinstance(own, dict) else {}
    own = {key: shortened(name, 200) for key, name in own.items() if key in shapes and isinstance(name, str)}
    return _Layout(tuple(found), tuple(shapes), shapes, own)


def _shape(feature: Mapping[str, Any]) -> tuple[int, ...] | None:
    """The shape of a column of numbers; None of a picture, a video, a text, or of one that is too large."""
    shape, kind = feature.get("shape"), str(feature.get("dtype"))
    if not re.fullmatch(r"float(16|32|64)|u?int(8|16|32|64)|bool", kind) or not isinstance(shape, list):
        return None
    if len(shape) > 8 or not all(isinstance(it, int) and 0 < it <= MOST_NUMBERS for it in shape):
        return None
    return tuple(shape) if math.prod(shape) <= MOST_NUMBERS else None


def _keys(layout: _Layout) -> tuple[str, ...]:
    return tuple(name for name in layout.columns if name not in (STATE, ACTION, NEXT_STATE))


def _names(features: Mapping[str, Any], column: str) -> tuple[str, ...]:
    """What the numbers of a column are called: a list, or a table with one list."""
    names = features[column].get("names")
    if isinstance(names, dict) and len(names) == 1:
        (names,) = names.values()
    size = math.prod(features[column]["shape"])
    if not isinstance(names, list) or len(names) != size or not all(isinstance(it, str) for it in names):
        return ()
    return tuple(shortened(it, 100) for it in names)


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
        self._has_next = NEXT_STATE in layout.columns
        width = 8 * sum(math.prod(shape) for shape in layout.shapes.values())
        self._rows = max(2, min(ROWS, PIECE_BYTES // width))
        self._seen = self._at = -1  # the episode, and its frame that waits

    def take(self, path: Path) -> Iterator[Piece]:
        require_regular(path, MOST_BYTES)
        with pq.ParquetFile(path) as file:
            _require_columns(path, file, self._layout)
            for batch in file.iter_batches(self._rows, columns=list(self._layout.columns)):
                table = {name: _array(path, batch, name, shape) for name, shape in self._layout.shapes.items()}
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
        frame, number = table[FRAME], int(table[EPISODE][0])
        where = f"{self._facts.path / self._file}, episode {number}"
        begins = number > self._seen and frame[0] == 0
        goes_on = number == self._seen and frame[0] == self._at
        if not (begins or goes_on) or (np.diff(frame) != 1).any():
            raise SchemaError(f"{where}: its frames do not follow one another, from 0 on")
        self._seen, self._at = number, int(frame[-1])
        count = len(frame) if ends and self._has_next else len(frame) - 1
        told = table[self._facts.success] if self._facts.success else None
        success = None if told is None else bool(np.asarray(told[: count if not ends else None], bool).any())
        if count == 0 and not ends:
            return
        state = require_finite(table[STATE], f"{where}: {STATE}")
        if self._has_next and count:
            after = require_finite(table[NEXT_STATE][count - 1 : count], f"{where}: {NEXT_STATE}")
            state = np.concatenate([state[:count], after])
        else:
            state = state[: count + 1]
        rewards = {RECORDED: REWARD, **{name: key for key, name in self._layout.own.items()}}
        first = int(frame[0])
        operator = f"{np.asarray(table[self._facts.operator]).ravel()[0]}" if self._facts.operator else ""
        yield Piece(
            number,
            first,
            state,
            require_finite(table[ACTION][:count], f"{where}: {ACTION}"),
            {name: table[name][:count] for name in _keys(self._layout) if name not in self._layout.own},
            {
                name: np.asarray(require_finite(table[key][:count], f"{where}: {key}"), np.float64).reshape(count)
                for name, key in rewards.items()
                if name in self._facts.rewards
            },
            success,
            operator,
            self._file,
            ends,
        )


def _require_columns(path: Path, file: pq.ParquetFile, layout: _Layout) -> None:
    missing = [name for name in layout.columns if name not in file.schema_arrow.names]
    if missing:
        raise SchemaError(f"{path} has no column {', '.join(missing)}, of which {INFO} tells")
    for number in range(file.metadata.num_row_groups):
        if file.metadata.row_group(number).total_byte_size > GROUP_BYTES:
            raise SchemaError(f"{path} has a group of rows of more than {GROUP_BYTES:,} bytes")


def _array(path: Path, batch: pa.RecordBatch, name: str, shape: tuple[int, ...]) -> NDArray[Any]:
    """A column, (rows,) where the shape is one number, else (rows, ...).

    Raises:
        SchemaError: It has gaps, or rows of another shape.
    """
    column = batch.column(name)
    size = math.prod(shape)
    while (
        pa.types.is_list(column.type) or pa.types.is_fixed_size_list(column.type) or pa.types.is_large_list(column.type)
    ):
        if column.null_count:
            raise SchemaError(f"{path}: {name} has gaps")
        column = column.flatten()
    if isinstance(column, pa.ExtensionArray):
        raise SchemaError(f"{path}: {name} is of the type {column.type}, not of lists of numbers")
    if column.null_count or len(column) != size * batch.num_rows:
        raise SchemaError(f"{path}: {name} has gaps, or other rows than the {list(shape)} that {INFO} tells")
    values = np.asarray(column.to_numpy(zero_copy_only=False))
    if values.dtype.kind not in "biuf":
        raise SchemaError(f"{path}: {name} holds {values.dtype}, no numbers")
    return values if shape == (1,) and name not in (STATE, ACTION) else values.reshape(batch.num_rows, *shape)
