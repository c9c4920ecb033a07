"""What a LeRobot data set tells of itself: ``meta/info.json``, the list of its episodes, and the texts of its tasks."""

import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import pyarrow.parquet as pq

from harness.errors import NewerFormat, SchemaError, one_line
from harness.files import open_regular, parse_json, read_bytes
from harness.record.dataset.open_dataset import MOST_EPISODES

from .dataset import MOST_KEYS, MOST_NUMBERS, whole

INFO_FILE, EPISODES, LISTS = Path("meta/info.json"), Path("meta/episodes.jsonl"), Path("meta/episodes")
KNOWN = ((2, 0), (2, 1), (3, 0))
"""Versions of the layout."""
STATE, ACTION, EPISODE, FRAME = "observation.state", "action", "episode_index", "frame_index"
REWARD, DONE = "next.reward", "next.done"
TASK_INDEX, TASKS = "task_index", "tasks"
NEEDED = (ACTION, EPISODE, FRAME)
SEEN_BEGIN = "observation."
"""How columns begin that were seen before the step."""
PLAIN_REWARD = "reward"
"""What some call ``next.reward``."""
SINGLE = (EPISODE, FRAME, TASK_INDEX, DONE)
"""Columns that hold one number of each frame."""
CHUNK, FILE = "data/chunk_index", "data/file_index"
DATA_PATH = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
LEFT_OUT = ("stats/", "videos/")
"""How keys of an episode begin that say nothing of it as a whole."""
MOST_FILES, LIST_BYTES = 1_000_000, 2**29
_SINGLE = re.compile(r"((fixed_size_)?list<\w+: )*(bool|u?int\d+|halffloat|float|double|(large_)?string)\b")
"""How the type of a column is called that holds a number, a text, or a list of these."""
_VERSION = re.compile(r"v?(\d{1,4})\.(\d{1,4})")


class Listing(NamedTuple):
    """The episodes that the metadata lists.

    Attributes:
        path: Where they stand.
        keys: What is known of an episode.
        rows: By number of the episode, a value of each key: a number, a text, None, or a list of texts.
    """

    path: Path
    keys: tuple[str, ...]
    rows: Mapping[int, Mapping[str, Any]]


def read_info(path: Path) -> dict[str, Any]:
    """The content of ``meta/info.json``.

    Raises:
        SchemaError: It tells of no columns, or of too many.
    """
    info = parse_json(read_bytes(path))
    if not isinstance(info, dict) or not isinstance(info.get("features"), dict):
        raise SchemaError(f"{path} tells of no features")
    if len(info["features"]) > MOST_KEYS or not all(isinstance(it, dict) for it in info["features"].values()):
        raise SchemaError(f"{path} tells of features that are none, or of more than {MOST_KEYS:,}")
    return info


def version_of(path: Path, info: Mapping[str, Any]) -> tuple[int, int]:
    """The version of the layout.

    Raises:
        NewerFormat: It is newer than those that are known.
        SchemaError: It is another.
    """
    told = one_line(str(info.get("codebase_version")), 40)
    found = _VERSION.fullmatch(told)
    version = (int(found[1]), int(found[2])) if found else (0, 0)
    if version in KNOWN:
        return version
    versions = ", ".join(f"v{major}.{minor}" for major, minor in KNOWN)
    if version > KNOWN[-1]:
        raise NewerFormat(f"{path} tells of version {told}, and {versions} are read: it is newer")
    raise SchemaError(f"{path} tells of version {told}, and {versions} are read")


def shapes_of(path: Path, features: Mapping[str, Any]) -> dict[str, tuple[int, ...]]:
    """By column of numbers, its shape. Pictures, videos, texts and what is too large are left out.

    Raises:
        SchemaError: A column that is needed is not among them.
    """
    shapes = {name: shape for name, feature in features.items() if (shape := _shape(feature)) is not None}
    for name in NEEDED:
        if name not in shapes:
            what = f" of 1 to {MOST_NUMBERS:,} numbers a frame" if name in features else ""
            raise SchemaError(f"{path} tells of no column {name}{what}")
    for name in (reward_in(shapes), *SINGLE):
        if name in shapes and math.prod(shapes[name]) != 1:
            raise SchemaError(f"{path}: the column {name} holds {math.prod(shapes[name]):,} numbers a frame, not one")
    return shapes


def seen_in(shapes: Mapping[str, Any]) -> tuple[str, ...]:
    """The columns of an observation: ``observation.state``; without it, all that were seen and are numbers."""
    return (STATE,) if STATE in shapes else tuple(sorted(name for name in shapes if name.startswith(SEEN_BEGIN)))


def reward_in(shapes: Mapping[str, Any]) -> str:
    """The column of the data set's own reward; empty if it has none."""
    return next((name for name in (REWARD, PLAIN_REWARD) if name in shapes), "")


def _shape(feature: Mapping[str, Any]) -> tuple[int, ...] | None:
    shape, kind = feature.get("shape"), str(feature.get("dtype"))
    if not re.fullmatch(r"float(16|32|64)|u?int(8|16|32|64)|bool", kind) or not isinstance(shape, list):
        return None
    if len(shape) > 8 or not all(isinstance(it, int) and 0 < it <= MOST_NUMBERS for it in shape):
        return None
    return tuple(shape) if math.prod(shape) <= MOST_NUMBERS else None


def names_of(features: Mapping[str, Any], shapes: Mapping[str, tuple[int, ...]], column: str) -> tuple[str, ...]:
    """What the numbers of a column are called: a list, or a table with one list."""
    names = features.get(column, {}).get("names")
    if isinstance(names, dict) and len(names) == 1:
        (names,) = names.values()
    is_list = isinstance(names, list) and all(isinstance(it, str) for it in names)
    fits = is_list and column in shapes and len(names) == math.prod(shapes[column])
    return tuple(one_line(it, 100) for it in names) if fits else ()


def read_listing(folder: Path) -> Listing:
    """The list of episodes: ``meta/episodes.jsonl`` up to v2.1, Parquet files in ``meta/episodes`` since v3.0.

    Raises:
        SchemaError: It lists an episode twice, or is no list of episodes.
    """
    if (folder / EPISODES).is_file():
        place, rows = folder / EPISODES, _json_lines(folder / EPISODES)
    else:
        place, rows = folder / LISTS, _tables(sorted((folder / LISTS).glob("*/*.parquet")))
    listed: dict[int, dict[str, Any]] = {}
    keys: dict[str, None] = {}
    for row in rows:
        number = whole(row.get(EPISODE))
        if number is None or number in listed:
            raise SchemaError(f"{place} has a row without {EPISODE}, or lists episode {number} twice")
        listed[number] = row
        keys |= dict.fromkeys(row)
        if len(listed) > MOST_EPISODES or len(keys) > MOST_KEYS:
            raise SchemaError(f"{place} lists more than {MOST_EPISODES:,} episodes, or {MOST_KEYS:,} keys")
    return Listing(place, tuple(keys), listed)


def _json_lines(path: Path) -> Iterator[dict[str, Any]]:
    for line in read_bytes(path, LIST_BYTES).splitlines():
        if not line.strip():
            continue
        row = parse_json(line)
        if not isinstance(row, dict):
            raise SchemaError(f"{path} has a line that is no table")
        yield {key: value for key, value in row.items() if key == TASKS or not isinstance(value, dict)}


def _tables(paths: list[Path]) -> Iterator[dict[str, Any]]:
    if len(paths) > MOST_FILES:
        raise SchemaError(f"{paths[0].parent} has more than {MOST_FILES:,} files")
    for path in paths:
        with open_regular(path, LIST_BYTES), pq.ParquetFile(path) as file:
            names = [
                it.name for it in file.schema_arrow if _SINGLE.match(str(it.type)) and not it.name.startswith(LEFT_OUT)
            ]
            if file.metadata.num_rows > MOST_EPISODES or len(names) > MOST_KEYS:
                raise SchemaError(f"{path} lists more than {MOST_EPISODES:,} episodes, or {MOST_KEYS:,} keys")
            for batch in file.iter_batches(columns=names):
                yield from batch.to_pylist()


def read_tasks(folder: Path) -> dict[int, str]:
    """By number, what a task is called: ``meta/tasks.jsonl``, or ``meta/tasks.parquet`` with texts as an index."""
    lines, table = folder / "meta/tasks.jsonl", folder / "meta/tasks.parquet"
    rows = _json_lines(lines) if lines.is_file() else _tables([table] if table.is_file() else [])
    named = {}
    for row in rows:
        number, text = whole(row.get(TASK_INDEX)), row.get("task", row.get("__index_level_0__"))
        if number is not None and isinstance(text, str):
            named[number] = one_line(text, 200)
    return named
