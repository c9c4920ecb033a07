"""What a cell leaves: one row per environment step, and one per episode start, in Parquet.

A trace is a file; one with more rows than a part (`harness.record.parts`) has others beside it, see `part_path`.

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
from harness.files.parquet import MOST_NUMBERS, open_parquet, require_room
from harness.files.plain import Plain
from harness.log import Log, LogFacts, in_memory
from harness.log.log import ROWS, Columns, joined
from harness.record.file_forms import read_form
from harness.record.folder import part_path, parts_of
from harness.record.parts import PART_ROWS, RowsWriter
from harness.reward import LARGEST_PAID
from harness.text import shortened

FORMAT = 3
"""Format 1 has no `held` and no `terminated`: both events ended an episode. Format 2 is always one file."""
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
        return json.dumps(self.to_json()).encode()

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


class TraceWriter(RowsWriter):
    """A `Recorder` that writes rows into a trace.

    Attributes:
        facts: Written with the next part.
    """

    def __init__(
        self,
        path: Path,
        dof: int,
        action_size: int,
        facts: EpisodeFacts = NOTHING_KNOWN,
        extras: Mapping[str, int] = NO_EXTRAS,
        part_rows: int = 0,
        after: int = 0,
    ) -> None:
        """Start the trace, or go on with it.

        Args:
            path: The file to write.
            dof: Length of qpos.
            action_size: Length of the action.
            facts: What is known of the episodes.
            extras: Those of `EXTRAS` that a row has, in their order, and the width of each.
            part_rows: As many rows as there will be at most, where all is to be one file.
            after: Go on behind so many rows, which are there; those behind them are forgotten.

        Raises:
            SchemaError: They are damaged.
        """
        super().__init__(path.parent, lambda part: part_path(path, part).name)
        self.facts = facts
        widths = {**dict.fromkeys(SCALARS, 1), "qpos": dof, "action": action_size, **extras}
        self._names = [name for name, width in widths.items() for _ in range(width)]
        number = pa.float64()
        kinds = {name: pa.list_(number, n) if name in LISTS else KINDS.get(name, number) for name, n in widths.items()}
        self._make_room(pa.schema(kinds), part_rows)
        if after:
            self._go_on(after, lambda part: trace_part(part, [*kinds]).values())
            for part in parts_of(path)[self._part + 1 :]:
                part.unlink()

    def close(self) -> None:
        """Write what is left.

        Raises:
            SimulationDiverged: A number is not finite, or too large to count with: the simulator's, or the reward's.
        """
        self._write()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _write(self) -> None:
        """The rows before a number that no reader takes stay."""
        self._schema = self._schema.with_metadata({FORMAT_KEY: str(FORMAT), FACTS_KEY: self.facts.to_bytes()})
        rows = self._block[: self._filled]
        bad = np.argwhere(~(np.abs(rows) <= LARGEST_PAID))  # a comparison with what is no number is false
        if not len(bad):
            super()._write()
            return
        row, column = bad[0]
        self._filled = int(row)
        super()._write()
        where = ", ".join(f"{key} {rows[row, COLUMN[key]]:.0f}" for key in INTEGERS)
        told = f"{rows[row, column]:g}, no number within {LARGEST_PAID:g},"
        raise SimulationDiverged(f"{self._names[column]} is {told} at {where}")


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


def require_rows(path: Path, count: int) -> None:
    """See that the first rows of a trace are there, so many of them; each number is read.

    Raises:
        SchemaError: They are not, or are damaged.
    """
    trace = read_trace(path)
    if (found := sum(len(piece["env"]) for piece in trace.pieces(trace.names))) < count:
        raise SchemaError(f"{path.name} has {found:,} rows, and {count:,} were written")


def term_names(path: Path) -> tuple[str, ...]:
    """The terms of the reward that a trace has columns of, in their order; its rows are not read.

    Raises:
        SchemaError: The file is damaged or is no Parquet file.
    """
    return tuple(name.removeprefix(TERM) for name in read_trace(path).columns if name.startswith(TERM))


def read_trace(path: Path) -> Log:
    """A trace, one that is being written too: as far as it was written. Each column is read when it is asked for.

    Raises:
        SchemaError: The file is damaged, is no trace or was written by a newer version; or its end tells of a number
            that is too large. A column that is damaged raises it when it is read, and so does every column of a file
            that was replaced by then.
    """
    paths = parts_of(path)
    parts = [_opened(part, MOST_NUMBERS // len(paths)) for part in paths]
    last, told = parts[-1].path, parts[-1].metadata.metadata
    for part in parts[:-1]:
        if part.metadata.num_rows != PART_ROWS or part.metadata.metadata != told:
            raise SchemaError(f"{part.path} is no part of the trace that ends with {last.name}")
    with reading(last, "trace"):
        episodes = EpisodeFacts.from_bytes(told[FACTS_KEY]) if FACTS_KEY in told else NOTHING_KNOWN
    facts = TraceFacts(path=path, format=f"trace, format {told[FORMAT_KEY].decode()}", episodes=episodes)
    trace = Log(facts, parts[-1].names, partial(_tables, parts))
    return trace if OBSTACLE in trace else _with_nothing_touched(trace, sum(it.metadata.num_rows for it in parts))


def trace_part(path: Path, names: Sequence[str]) -> Columns:
    """Columns of one file of a trace, all its rows as they are now.

    Raises:
        SchemaError: It is damaged, or no trace that this version reads.
    """
    with reading(path, "trace"), open_parquet(path, TRACE_BYTES) as file:
        _require_trace(file, path, MOST_NUMBERS)
        return joined([*_rows(file, path, names)])


@dataclass(frozen=True)
class _Part:
    """A file of a trace as it was when it was opened; `identity` is what one that takes its place has otherwise."""

    path: Path
    identity: tuple[int, int, int]
    metadata: pq.FileMetaData
    names: tuple[str, ...]


def _opened(path: Path, most: int) -> _Part:
    with reading(path, "trace"), open_parquet(path, TRACE_BYTES) as file:
        return _Part(path, _identity(path), file.metadata, _require_trace(file, path, most))


def _require_trace(file: pq.ParquetFile, path: Path, most: int) -> tuple[str, ...]:
    """See that a file is of a trace; gives the columns that it has, or that follow from others."""
    version = (file.metadata.metadata or {}).get(FORMAT_KEY, b"none").decode()
    if version not in map(str, range(1, FORMAT + 1)):
        raise SchemaError(f"{path} is a trace of format {shortened(version, 20)}, this version reads 1 to {FORMAT}")
    lacking = SINCE_2 if version == "1" else ()
    _require_columns(file.schema_arrow, lacking, path)
    known = tuple(filter(_is_known, file.schema_arrow.names))
    for name, chunk in require_room(path, file, known, most):
        if chunk.least is not None and chunk.greatest is not None:
            _require_moderate(chunk.least, chunk.greatest, f"{path}: {name}")
    return known + lacking


def _identity(path: Path) -> tuple[int, int, int]:
    told = path.stat()
    return told.st_ino, told.st_size, told.st_mtime_ns


def _tables(parts: Sequence[_Part], names: Sequence[str]) -> Iterator[Columns]:
    """The rows of some columns; the end of a file is not read again."""
    for part in parts:
        given: dict[str, Any] = {"metadata": part.metadata, "page_checksum_verification": True}
        with reading(part.path, "trace"), pq.ParquetFile(part.path, **given) as file:
            if _identity(part.path) != part.identity:  # its end says where the rows of the other one stood
                raise SchemaError(f"{part.path} was replaced since it was opened: type the command again")
            yield from _rows(file, part.path, names)


def _rows(file: pq.ParquetFile, path: Path, names: Sequence[str]) -> Iterator[Columns]:
    lacking = [name for name in names if name in SINCE_2 and name not in file.schema_arrow.names]
    asked = [*dict.fromkeys((*(name for name in names if name not in lacking), *(ENDS_OF_1 if lacking else ())))]
    batches = file.iter_batches(ROWS, columns=asked, use_threads=False)
    tables = (pa.Table.from_batches([batch]) for batch in batches) if file.metadata.num_rows else [file.read(asked)]
    for table in tables:
        rows = {name: to_numpy(table.column(name), f"{path}: {name}") for name in asked}
        if lacking:
            ended = rows["ground"] | rows["reached"]
            rows |= {"terminated": ended, "held": np.zeros_like(ended)}
        yield {name: rows[name] for name in names}


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
