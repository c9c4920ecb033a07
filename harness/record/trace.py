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

What is known of the episodes beside their rows is in the file's metadata, see `EpisodeFacts`.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, Protocol, Self

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray
from pydantic import ConfigDict, with_config

from harness.arrays import Float
from harness.errors import SchemaError, SimulationDiverged
from harness.files.bounded import reading
from harness.files.parquet import open_parquet, read_chunks, require_room, table_of
from harness.files.plain import Plain
from harness.log import Log, LogFacts, in_memory
from harness.log.log import ROWS, Columns
from harness.record.file_forms import read_form
from harness.reward import LARGEST_PAID
from harness.text import shortened

FORMAT = 2
"""Format 1 has no `held` and no `terminated`: both events ended an episode."""
FORMAT_KEY = b"harness.trace"
FACTS_KEY = b"harness.facts"
"""The key of the `EpisodeFacts`; a file of an earlier version has none."""

TRACE_BYTES = 2**35
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
SINCE_2, ENDS_OF_1 = ("held", "terminated"), ("ground", "reached")
SCALARS = INTEGERS + NUMBERS + FLAGS
COLUMN = {name: index for index, name in enumerate(SCALARS)}
QVEL = "qvel"
TERM = "reward/"
"""Begins the name of the column of a term."""
OBSTACLE, OBSTACLES = "obstacle", "obstacles"
"""Columns; the first is False throughout where a trace does not have it."""
EXTRAS = ("arm", OBSTACLE, OBSTACLES, QVEL)
"""Columns that not every trace has, in the order in which they stand; those of terms follow."""
KINDS = {**dict.fromkeys((*INTEGERS, "arm"), pa.int32()), **dict.fromkeys((*FLAGS, OBSTACLE), pa.bool_())}
LISTS = ("qpos", "action", OBSTACLES, QVEL)
"""Columns of several numbers. What is in neither holds one number."""
NO_EXTRAS: Mapping[str, int] = MappingProxyType({})

Rows = Float


LATER = ("arms", "error", "unit", "target_moves")
"""Left out of the file where there is nothing to tell: it stays, byte for byte, as it was before there were any."""


@with_config(ConfigDict(strict=True))
@dataclass(frozen=True)
class EpisodeFacts(Plain):
    """Facts that metrics need and that no row tells; None where the file says nothing, as those of version 0.1.

    Attributes:
        horizon: An episode is truncated after so many environment steps.
        control_period: Duration of an environment step, [s].
        ik_steps: Of an evaluation: the environment steps that the arm's own kinematics take to the target, by env, from
            the same start in the same simulator; None of an env where they do not reach it. None altogether where they
            cannot act, see `harness.env.arm_observation`.
        work: Of an evaluation: the mechanical work of each env's episode, see `harness.robot.energy`, [J]. None where
            the arm jumps from pose to pose or its links have no mass.
        arms: Where the arms of episodes differ, how: for each arm the factors of the masses of the links that move,
            those of their sizes, and that of the friction of the drives; 1 is as drawn. The column `arm` of a row is
            the number of its episode's. None where they do not differ.
        error: What the columns of distances hold, of a task that asks for more than a point that stays, as ``pose
            error``; None of one that does not: the distance from end effector to target, in metres.
        unit: Of the error.
        target_moves: True of a task whose target moves.
    """

    horizon: int | None = None
    control_period: float | None = None
    ik_steps: tuple[int | None, ...] | None = None
    work: tuple[float, ...] | None = None
    arms: tuple[tuple[tuple[float, ...], tuple[float, ...], float], ...] | None = None
    error: str | None = None
    unit: str | None = None
    target_moves: bool | None = None

    def to_bytes(self) -> bytes:
        """For a file; `from_bytes` gives the same facts back."""
        told = {name: value for name, value in self.to_json().items() if value is not None or name not in LATER}
        return json.dumps(told).encode()

    @classmethod
    def from_bytes(cls, text: bytes) -> Self:
        """What `to_bytes` wrote; facts that a newer version added are left out.

        Raises:
            ValueError: It is something else.
        """
        return read_form(cls, json.loads(text))


NOTHING_KNOWN = EpisodeFacts()


@dataclass(frozen=True, kw_only=True)
class TraceFacts(LogFacts):
    """What is known of a trace beside its rows.

    Attributes:
        episodes: What is known of its episodes.
    """

    episodes: EpisodeFacts = NOTHING_KNOWN


def episode_facts(log: Log) -> EpisodeFacts:
    """What is known of the episodes of a log; nothing, of one that is no trace."""
    return log.facts.episodes if isinstance(log.facts, TraceFacts) else NOTHING_KNOWN


def with_episode_facts(trace: Log, facts: EpisodeFacts) -> Log:
    """The same trace of whose episodes something else is known."""
    return replace(trace, facts=TraceFacts(**{**vars(trace.facts), "episodes": facts}))


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
        widths = {**dict.fromkeys(SCALARS, 1), "qpos": dof, "action": action_size, **extras}
        self._names = [name for name, width in widths.items() for _ in range(width)]
        self._block = np.empty((self.BLOCK, len(self._names)))
        self._filled = 0
        number = pa.float64()
        kinds = {name: pa.list_(number, n) if name in LISTS else KINDS.get(name, number) for name, n in widths.items()}
        self.schema = pa.schema(kinds, metadata={FORMAT_KEY: str(FORMAT).encode()})
        self._file = pq.ParquetWriter(path, self.schema, compression="zstd")

    def append(self, rows: Rows) -> None:
        """Copy a batch of rows, (n, width)."""
        while len(rows):  # blocks are full, however the rows come: a file is that of its rows alone
            taken = rows[: self.BLOCK - self._filled]
            self._block[self._filled : self._filled + len(taken)] = taken
            self._filled += len(taken)
            rows = rows[len(taken) :]
            if self._filled == self.BLOCK:
                self._flush()

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

    def __exit__(self, *_: object) -> None:
        self.close()

    def _flush(self) -> None:
        rows = self._block[: self._filled]
        if self._episodes is not None:
            rows = rows[rows[:, COLUMN["episode"]] < self._episodes]
        bad = np.argwhere(~(np.abs(rows) <= LARGEST_PAID))  # a comparison with what is no number is false
        if len(bad):
            row, column = bad[0]
            where = ", ".join(f"{key} {rows[row, COLUMN[key]]:.0f}" for key in INTEGERS)
            told = f"{rows[row, column]:g}, no number within {LARGEST_PAID:g},"
            raise SimulationDiverged(f"{self._names[column]} is {told} at {where}")
        if len(rows):
            self._file.write_table(table_of(rows, self.schema))
        self._filled = 0


def terms_of(trace: Log, begin: str = TERM) -> dict[str, NDArray[Any]]:
    """What each term of the reward paid, (rows,), by name; empty without columns that begin so."""
    return {name.removeprefix(begin): trace[name] for name in trace.columns if name.startswith(begin)}


def trace_of(columns: Columns, facts: EpisodeFacts = NOTHING_KNOWN) -> Log:
    """A trace in memory, (rows, ...) each column."""
    trace = in_memory(TraceFacts(path=Path("trace"), format="trace", episodes=facts), columns)
    return _with_nothing_touched(trace, len(trace))


def _with_nothing_touched(trace: Log, rows: int) -> Log:
    """The same trace; no step of one that does not say so touched an obstacle."""
    return trace if OBSTACLE in trace else trace.add({OBSTACLE: np.broadcast_to(np.False_, rows)})


def require_plausible(path: Path, most: int) -> None:
    """See from the end of a trace, without its rows, whether a cell can have left it.

    Args:
        path: The file.
        most: Rows that it may have; it has at least one.

    Raises:
        SchemaError: It has another number of rows, or holds a number that is too large; or as `read_trace`.
    """
    with reading(path, "trace"), open_parquet(path, TRACE_BYTES) as file:
        metadata = file.metadata
        if not 0 < metadata.num_rows <= most:
            raise SchemaError(f"{path} has {metadata.num_rows:,} rows, 1 to {most:,} are allowed")
        columns = [metadata.schema.column(place).path for place in range(metadata.num_columns)]
        for group in read_chunks(path):
            for name, chunk in zip(columns, group, strict=True):
                if chunk.least is not None and chunk.greatest is not None:
                    _require_moderate(chunk.least, chunk.greatest, f"{path}: {name}")


def term_names(path: Path) -> tuple[str, ...]:
    """The terms of the reward that a trace has columns of, in their order; its rows are not read.

    Raises:
        SchemaError: The file is damaged or is no Parquet file.
    """
    return tuple(name.removeprefix(TERM) for name in read_trace(path).columns if name.startswith(TERM))


def read_trace(path: Path) -> Log:
    """A trace. Each column is read when it is asked for.

    Raises:
        SchemaError: The file is damaged, is no trace or was written by a newer version. A column that is damaged raises
            it when it is read, and so does every column of a file that was replaced by then.
    """
    with reading(path, "trace"), open_parquet(path, TRACE_BYTES) as file:
        opened, metadata, there = _identity(path), file.metadata, file.schema_arrow.names
        told = metadata.metadata or {}
        version = told.get(FORMAT_KEY, b"none").decode()
        if version not in map(str, range(1, FORMAT + 1)):
            raise SchemaError(f"{path} is a trace of format {shortened(version, 20)}, this version reads 1 to {FORMAT}")
        lacking = SINCE_2 if version == "1" else ()
        known = tuple(filter(_is_known, there))
        _require_columns(file.schema_arrow, lacking, path)
        require_room(path, file, known)
        facts = EpisodeFacts.from_bytes(told[FACTS_KEY]) if FACTS_KEY in told else NOTHING_KNOWN
        read = partial(_tables, path, opened, metadata)
        trace = Log(TraceFacts(path=path, format=f"trace, format {version}", episodes=facts), known, read)
        if lacking:
            ended = trace["ground"] | trace["reached"]
            trace = trace.add({"terminated": ended, "held": np.zeros_like(ended)})
        return trace if OBSTACLE in known else _with_nothing_touched(trace, metadata.num_rows)


def part_of(path: Path, number: int) -> Path:
    """A part of the trace `path`, counted from 0."""
    return path.with_name(f"{path.stem}.{number}")


def _identity(path: Path) -> tuple[int, int, int]:
    """What a file that takes the place of another has otherwise."""
    told = path.stat()
    return told.st_ino, told.st_size, told.st_mtime_ns


def _tables(
    path: Path, opened: tuple[int, int, int], metadata: pq.FileMetaData, names: Sequence[str]
) -> Iterator[Columns]:
    """The rows of some columns; the end of the file is not read again."""
    with reading(path, "trace"), pq.ParquetFile(path, metadata=metadata) as file:
        if _identity(path) != opened:  # its end says where the rows of the other one stood
            raise SchemaError(f"{path} was replaced since it was opened: type the command again")
        batches = file.iter_batches(ROWS, columns=names, use_threads=False)
        tables = (pa.Table.from_batches([batch]) for batch in batches) if metadata.num_rows else [file.read(names)]
        for table in tables:
            yield {name: to_numpy(table.column(name), f"{path}: {name}") for name in names}


def _is_known(column: str) -> bool:
    return column in (*SCALARS, *LISTS, *EXTRAS) or column.startswith(TERM)


def _require_columns(schema: pa.Schema, lacking: Sequence[str], path: Path) -> None:
    if missing := [name for name in ("reward", *(ENDS_OF_1 if lacking else ())) if name not in schema.names]:
        raise SchemaError(f"{path} has no column {', '.join(missing)}")
    for name in filter(_is_known, schema.names):
        found, number = schema.field(name).type, pa.float64()
        is_list = name in LISTS  # of any length
        expected = pa.list_(number, getattr(found, "list_size", 1)) if is_list else KINDS.get(name, number)
        if found != expected:
            raise SchemaError(f"{path} has a column {name} of {found}, not of {expected}")


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
