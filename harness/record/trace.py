"""What a cell leaves: one row per environment step, and one per episode start, in Parquet.

==================  ===========================================================================================
env                 number of the env in the batch
episode             counted from 0 in each env
step                t, 0 in the row of the episode's start
begin_distance      Bd = d(0), [m]
previous_best       Pb before this step; Bd in the start row, [m]
distance            d(t), end effector to target, [m]
delta_distance      d(t) - previous_best, [m]
reward              the shaped reward alone; 0 in the start row
reward_ground       the event terms, paid on top: ground contact,
reward_target       target reached,
reward_step         the price of the step
target_x .. _z      world frame, [m]
end_effector_x .._z world frame, [m]
ground, reached     whether the step touched the ground, reached the target
held                whether the motion asked for could not be done, and the arm was held
terminated          whether one of these ended the episode
truncated           whether the step was the last that the horizon allows
qpos                joint positions after the step, list of dof numbers, [rad]
action              what the policy asked for, list of numbers; zeros in the start row
==================  ===========================================================================================

A task with obstacles or varied arms, and a reward that reads more or has terms, leaves some of these columns too:

==================  ===========================================================================================
arm                 which of the varied arms the episode has, see `EpisodeFacts.arms`
obstacle            whether the step touched an obstacle; what that pays is in `reward_ground`
obstacles           those of the episode, list of 7 numbers each, see `harness.conditions.obstacles`
qvel                joint speeds after the step, list of dof numbers, [rad/s]; where a reward of the experiment reads it
reward/TERM         what a term of the reward paid; `reward` is their sum, added in this order
==================  ===========================================================================================

What is known of the episodes beside their rows is in the file's metadata, see `harness.record.episode_facts`.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType, TracebackType
from typing import Any, Protocol

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import SchemaError, SimulationDiverged
from harness.files.bounded import reading, require_regular
from harness.files.parquet import require_room
from harness.record.episode_facts import EpisodeFacts
from harness.record.row_steps import TOUCHED, RowSteps, targets_touched
from harness.record.row_steps import Rows as StepRows
from harness.reward import LARGEST_PAID, Steps
from harness.reward.steps import joined, rows_of

FORMAT = 2
"""Format 1 has no `held` and no `terminated`: both events ended an episode."""
FORMAT_KEY = b"harness.trace"
FACTS_KEY = b"harness.facts"
"""The key of the `EpisodeFacts`; a file of an earlier version has none."""
NOTHING_KNOWN = EpisodeFacts()

TRACE_BYTES, MOST_ROWS = 2**35, 200_000_000
"""Most that is read of a trace."""

INTEGERS = ("env", "episode", "step")
NUMBERS = (
    "begin_distance",
    "previous_best",
    "distance",
    "delta_distance",
    "reward",
    "reward_ground",
    "reward_target",
    "reward_step",
    "target_x",
    "target_y",
    "target_z",
    "end_effector_x",
    "end_effector_y",
    "end_effector_z",
)
FLAGS = ("ground", "reached", "held", "terminated", "truncated")
SINCE_2 = ("held", "terminated")
SCALARS = INTEGERS + NUMBERS + FLAGS
COLUMN = {name: index for index, name in enumerate(SCALARS)}
QVEL = "qvel"
TERM = "reward/"
"""Begins the name of the column of a term."""
EXTRAS = {"arm": pa.int32(), "obstacle": pa.bool_(), "obstacles": pa.list_(pa.float64()), QVEL: pa.list_(pa.float64())}
"""Columns that not every trace has, in the order in which they stand; those of terms follow."""
OBSTACLE, OBSTACLES = "obstacle", "obstacles"
"""Columns; the first is False throughout where a trace does not have it."""
FIELDS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        **{name: (name,) for name in ("qpos", QVEL, "action", "ground")},
        **{name: tuple(f"{name}_{axis}" for axis in "xyz") for name in ("end_effector", "target")},
    }
)
"""The columns of each field of `harness.reward.steps.ARM` that a trace has beside the distances."""
NO_EXTRAS: Mapping[str, int] = MappingProxyType({})

Rows = Float


class Recorder(Protocol):
    """Takes the rows of an environment. A row is `SCALARS`, then qpos, the action, and what there is of `EXTRAS`."""

    def append(self, rows: Rows) -> None:
        """Take a batch of rows, (n, width), which belong to the caller: keep copies."""


class TraceWriter:
    """A `Recorder` that writes rows to a Parquet file, a block at a time; all are exact in float64.

    Attributes:
        facts: Written when the file is finished.
    """

    BLOCK = 16_384

    def __init__(
        self,
        path: Path,
        dof: int,
        action_size: int,
        episodes: int | None = None,
        facts: EpisodeFacts = NOTHING_KNOWN,
        extras: Mapping[str, int] = NO_EXTRAS,
    ) -> None:
        """Start the file.

        Args:
            path: The file to write.
            dof: Length of qpos.
            action_size: Length of the action.
            episodes: Keep the first so many episodes of each env only; all if None.
            facts: What is known of the episodes.
            extras: Those of `EXTRAS` that a row has, in their order, and the width of each.
        """
        self.facts = facts
        self._episodes = episodes
        self._widths = {"qpos": dof, "action": action_size, **extras}
        self._block = np.empty((self.BLOCK, len(SCALARS) + sum(self._widths.values())))
        self._filled = 0
        self.schema = trace_schema(dof, action_size, extras)
        self._file = pq.ParquetWriter(path, self.schema, compression="zstd")

    def append(self, rows: Rows) -> None:
        """Copy a batch of rows, (n, width)."""
        end = self._filled + len(rows)
        while end > self.BLOCK:  # blocks are full, however the rows come: a file is that of its rows alone
            room = self.BLOCK - self._filled
            self._block[self._filled :] = rows[:room]
            self._filled = self.BLOCK
            self._flush()
            rows, end = rows[room:], len(rows) - room
        self._block[self._filled : end] = rows
        self._filled = end

    def close(self) -> None:
        """Write what is left and finish the file.

        Raises:
            SimulationDiverged: A number is not finite, or too large to count with: the simulator's, or the reward's.
        """
        try:
            self._flush()
        finally:
            self._file.add_key_value_metadata({FACTS_KEY: self.facts.to_bytes()})
            self._file.close()

    def __enter__(self) -> "TraceWriter":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        self.close()

    def _flush(self) -> None:
        rows = self._block[: self._filled]
        if self._episodes is not None:
            rows = rows[rows[:, COLUMN["episode"]] < self._episodes]
        self._require_moderate(rows)
        if len(rows):
            self._file.write_table(self._table(rows))
        self._filled = 0

    def _require_moderate(self, rows: Rows) -> None:
        if rows.size and rows.min() >= -LARGEST_PAID and rows.max() <= LARGEST_PAID:
            return
        bad = np.argwhere(~(np.abs(rows) <= LARGEST_PAID))  # a comparison with what is no number is false
        if len(bad):
            row, column = bad[0]
            name = SCALARS[column] if column < len(SCALARS) else ", ".join(self._widths)
            where = ", ".join(f"{key} {rows[row, COLUMN[key]]:.0f}" for key in INTEGERS)
            told = f"beyond {LARGEST_PAID:g}" if np.isfinite(rows[row, column]) else "not finite"
            raise SimulationDiverged(f"{name} is {told} at {where}")

    def _table(self, rows: Rows) -> pa.Table:
        columns = [pa.array(rows[:, index].astype(_numpy_type(name))) for name, index in COLUMN.items()]
        ends = len(SCALARS) + np.cumsum(list(self._widths.values()))
        for end, (name, width) in zip(ends, self._widths.items(), strict=True):
            columns.append(_to_arrow(rows[:, end - width : end], self.schema.field(name).type))
        return pa.Table.from_arrays(columns, schema=self.schema)


def trace_schema(dof: int, action_size: int, extras: Mapping[str, int] = NO_EXTRAS) -> pa.Schema:
    """Columns and types of a trace file."""
    scalars = [(name, pa.from_numpy_dtype(_numpy_type(name))) for name in SCALARS]
    lists = [("qpos", pa.list_(pa.float64(), dof)), ("action", pa.list_(pa.float64(), action_size))]
    more = [(name, _sized(EXTRAS.get(name, pa.float64()), width)) for name, width in extras.items()]
    return pa.schema(scalars + lists + more, metadata={FORMAT_KEY: str(FORMAT).encode()})


def _sized(kind: pa.DataType, width: int) -> pa.DataType:
    return pa.list_(kind.value_type, width) if pa.types.is_list(kind) else kind


def _to_arrow(part: Rows, kind: pa.DataType) -> pa.Array:
    """A part of the rows, (n, width), as a column."""
    if pa.types.is_fixed_size_list(kind):
        return pa.FixedSizeListArray.from_arrays(part.ravel(), part.shape[1])
    return pa.array(part[:, 0].astype(kind.to_pandas_dtype()))


def _numpy_type(name: str) -> type[np.generic]:
    if name in INTEGERS:
        return np.int32
    return np.bool_ if name in FLAGS else np.float64


KNOWN = trace_schema(1, 1, dict.fromkeys(EXTRAS, 1))
"""All columns that are read, whatever else is there; lists may have other lengths."""


@dataclass(frozen=True, eq=False)
class Trace:
    """A recorded trace in memory: one numpy array per column, and what is known of its episodes."""

    columns: dict[str, NDArray[Any]]
    facts: EpisodeFacts = NOTHING_KNOWN

    def __getitem__(self, name: str) -> NDArray[Any]:
        """A column, (rows,), or (rows, n) for qpos, action and obstacles."""
        if name == OBSTACLE and name not in self.columns:
            return np.zeros(len(self), bool)
        return self.columns[name]

    def __len__(self) -> int:
        return len(self.columns["reward"])

    def has_field(self, name: str) -> bool:
        """Whether steps have a field; distances they always have."""
        return set(FIELDS.get(name, ())) <= self.columns.keys()

    def field(self, name: str) -> NDArray[Any] | None:
        """A field of `FIELDS`, (rows, ...), as the env told it; None where it is not recorded."""
        if not self.has_field(name):
            return None
        columns = [self.columns[column] for column in FIELDS[name]]
        return columns[0] if len(columns) == 1 else np.stack(columns, axis=1)

    def rows(self, fields: Collection[str]) -> StepRows:
        """The rows that steps are made of, with those of `FIELDS` that are asked for and recorded."""
        found = {name: self.field(name) for name in FIELDS if name in fields}
        more = {name: values for name, values in found.items() if values is not None}
        flags = [self.columns[name] for name in TOUCHED if name in self.columns]
        touched = targets_touched(*flags) if len(flags) == len(TOUCHED) else None
        six = self["begin_distance"], self["previous_best"], self["distance"]
        return StepRows(self["step"] == 0, *six, touched, more)

    def steps(self, fields: Collection[str]) -> Steps:
        """Every row as a step that a reward or a measure is given, in the trace's order.

        Args:
            fields: Which of `FIELDS` steps have beside the distances, where they are recorded.
        """
        rows, runs = self.rows(fields), self.runs
        if runs is None:
            return RowSteps().of(rows)[0]
        return rows_of(joined([RowSteps().of(rows.part(run))[0] for run in runs]), np.argsort(np.concatenate(runs)))

    @cached_property
    def runs(self) -> list[NDArray[np.int64]] | None:
        """Row numbers of each run, env after env; None where all rows are one run in their order.

        A new run begins at an env that does not begin with a start row.

        Rows after a start row do not depend on rows before it. So several envs in a row can be one run. For the 100
        envs of an evaluation a reward then takes a fifth of the time of 100 runs, and less if it has a memory.
        """
        env = self["env"]
        if (env[1:] == env[:-1]).all():
            return None
        order = np.argsort(env, kind="stable")
        is_next = np.diff(env[order]) != 0
        return np.split(order, np.flatnonzero(is_next & (self["step"][order][1:] != 0)) + 1)

    @property
    def terms(self) -> dict[str, NDArray[Any]]:
        """What each term of the reward paid, (rows,), by name; empty without terms."""
        return {name.removeprefix(TERM): values for name, values in self.columns.items() if name.startswith(TERM)}

    @cached_property
    def last_rows(self) -> NDArray[np.int64]:
        """Row numbers of the ends of finished episodes."""
        ended = self["terminated"] | self["truncated"]
        rows: NDArray[np.int64] = np.flatnonzero(ended)
        return rows

    @cached_property
    def episodes(self) -> list[NDArray[np.int64]]:
        """Row numbers of each finished episode, its start row first, by env and in order."""
        return episode_rows(self["env"], self["episode"], self["terminated"] | self["truncated"])


def episode_rows(
    env: NDArray[np.int32], episode: NDArray[np.int32], ended: NDArray[np.bool_]
) -> list[NDArray[np.int64]]:
    """Row numbers of each finished episode, by env and in order.

    Args:
        env: Of each row, (rows,).
        episode: Counted from 0 in each env.
        ended: Whether the row is the last of its episode.
    """
    key = env.astype(np.int64) << 32 | episode
    order = np.argsort(key, kind="stable")
    parts = np.split(order, np.flatnonzero(np.diff(key[order])) + 1)
    return [rows for rows in parts if len(rows) and ended[rows[-1]]]


def require_plausible(path: Path, most: int) -> None:
    """See from the end of a trace, without its rows, whether a cell can have left it.

    Args:
        path: The file.
        most: Rows that it may have; it has at least one.

    Raises:
        SchemaError: It has another number of rows, or holds a number that is too large; or as `read_trace`.
    """
    with reading(path, "trace"):
        require_regular(path, TRACE_BYTES)
        metadata = pq.read_metadata(path)
        if not 0 < metadata.num_rows <= most:
            raise SchemaError(f"{path} has {metadata.num_rows:,} rows, 1 to {most:,} are allowed")
        groups = (metadata.row_group(number) for number in range(metadata.num_row_groups))
        for column in (group.column(number) for group in groups for number in range(metadata.num_columns)):
            told = column.statistics
            if told is not None and told.has_min_max and isinstance(told.min, float):
                _require_moderate(told.min, told.max, f"{path}: {column.path_in_schema}")


def term_names(path: Path) -> tuple[str, ...]:
    """The terms of the reward that a trace has columns of, in their order; its rows are not read.

    Raises:
        SchemaError: The file is damaged or is no Parquet file.
    """
    with reading(path, "trace"):
        require_regular(path, TRACE_BYTES)
        return tuple(name.removeprefix(TERM) for name in pq.read_schema(path).names if name.startswith(TERM))


def read_trace(path: Path, columns: list[str] | None = None) -> Trace:
    """Read a trace, all columns or some.

    Raises:
        SchemaError: The file is damaged, is no trace or was written by a newer version.
    """
    with reading(path, "trace"):
        require_regular(path, TRACE_BYTES)
        file = pq.ParquetFile(path)
        version = _version(file.schema_arrow, path)
        if columns is not None and OBSTACLE not in file.schema_arrow.names:
            columns = [name for name in columns if name != OBSTACLE]
        if columns is None:
            there = [name for name in file.schema_arrow.names if _is_known(name)]
        else:
            there = columns if version > 1 else _columns_of_1(columns)
        _require_columns(file.schema_arrow, _columns_of_1(there) if version == 1 else there, path)
        _require_rows(file, path)
        require_room(file, there)
        table, facts = file.read(columns=there), _facts(file)
        arrays = {name: to_numpy(table.column(name), f"{path}: {name}") for name in table.column_names}
    if version == 1:
        terminated = arrays["ground"] | arrays["reached"]
        arrays.update(terminated=terminated, held=np.zeros_like(terminated))
    return Trace(arrays if columns is None else {name: arrays[name] for name in columns}, facts)


def _is_known(column: str) -> bool:
    return column in KNOWN.names or column.startswith(TERM)


def _columns_of_1(columns: list[str]) -> list[str]:
    """What to read of a file of format 1, from which the columns that it lacks follow."""
    return list(dict.fromkeys([*(name for name in columns if name not in SINCE_2), "ground", "reached"]))


def _version(schema: pa.Schema, path: Path) -> int:
    version = (schema.metadata or {}).get(FORMAT_KEY, b"none").decode()
    if version not in {str(known) for known in range(1, FORMAT + 1)}:
        raise SchemaError(f"{path} is a trace of format {version}, this version reads 1 to {FORMAT}")
    return int(version)


def _facts(file: pq.ParquetFile) -> EpisodeFacts:
    written = (file.metadata.metadata or {}).get(FACTS_KEY)
    return NOTHING_KNOWN if written is None else EpisodeFacts.from_bytes(written)


def _require_columns(schema: pa.Schema, columns: list[str], path: Path) -> None:
    missing = [name for name in columns if name not in schema.names]
    if missing:
        raise SchemaError(f"{path} has no column {', '.join(missing)}")
    for name in filter(_is_known, schema.names):
        found, expected = schema.field(name).type, KNOWN.field(name).type if name in KNOWN.names else pa.float64()
        if pa.types.is_fixed_size_list(expected):
            right = pa.types.is_fixed_size_list(found) and found.value_type == expected.value_type
        else:
            right = found == expected
        if not right:
            raise SchemaError(f"{path} has a column {name} of {found}, not of {expected}")


def _require_rows(file: pq.ParquetFile, path: Path) -> None:
    if file.metadata.num_rows > MOST_ROWS:
        raise SchemaError(f"{path} has {file.metadata.num_rows:,} rows, {MOST_ROWS:,} are allowed")


def to_numpy(column: pa.ChunkedArray, noun: str) -> NDArray[Any]:
    """A column of a trace, (rows,) or (rows, n).

    Raises:
        SchemaError: A value is missing, or too large.
    """
    if pa.types.is_fixed_size_list(column.type):
        flat = np.asarray(column.combine_chunks().flatten().to_numpy()).reshape(len(column), column.type.list_size)
    else:
        flat = np.asarray(column.to_numpy())
    if column.null_count:
        raise SchemaError(f"{noun} holds a value that is not a finite number")
    if flat.dtype.kind == "f" and flat.size:
        _require_moderate(flat.min(), flat.max(), noun)
    return flat


def _require_moderate(least: float, most: float, noun: str) -> None:
    if not (least >= -LARGEST_PAID and most <= LARGEST_PAID):  # a comparison with what is no number is false
        raise SchemaError(f"{noun} holds a value that is not a finite number, or one beyond {LARGEST_PAID:g}")
