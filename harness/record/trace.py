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
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, Self

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray
from pydantic import ConfigDict, with_config

from harness.arrays import Float
from harness.errors import SchemaError, SimulationDiverged, UsageError
from harness.face import lookup
from harness.files.bounded import reading
from harness.files.parquet import MOST_NUMBERS, open_parquet, require_room
from harness.files.plain import Plain
from harness.log import Log, LogFacts, in_memory
from harness.log.log import UNCOUNTABLE, Columns, episode_sums, is_countable, uncountable_text
from harness.record.file_forms import read_form
from harness.record.folder import parts_of
from harness.record.parts import PART_BYTES, PART_ROWS, RowsWriter, open_part, rows_of
from harness.reward.steps import ENDS
from harness.text import shortened

FORMAT = 3
"""Format 1 has no `held` and no `terminated`: both events ended an episode. Format 2 is always one file."""
FORMAT_KEY = b"harness.trace"
FACTS_KEY = b"harness.facts"
"""The key of the `EpisodeFacts`; a file of an earlier version has none."""

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
EVENTS = tuple(name for name in NUMBERS if name.startswith("reward_"))
"""The columns of the event terms, which are the same under every reward."""
PAID = ("reward", *EVENTS)
"""The columns whose sum is what an episode was paid: the shaped reward and the event terms."""
FLAGS = ("ground", "reached", "held", *ENDS)
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

    def __getattr__(self, name: str) -> Any:
        """Nothing: 0.2 had the facts of the episodes here.

        Raises:
            AttributeError: Says where they are now.
        """
        where = f"write log.facts.episodes.{name}" if name in vars(NOTHING_KNOWN) else "docs/plugins.md tells what is"
        raise AttributeError(f"the facts of a log have no '{name}': {where}")


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
        super().__init__(path)
        self.facts = facts
        widths = {**dict.fromkeys(SCALARS, 1), "qpos": dof, "action": action_size, **extras}
        self._names = [name for name, width in widths.items() for _ in range(width)]
        number = pa.float64()
        kinds = {name: pa.list_(number, n) if name in LISTS else KINDS.get(name, number) for name, n in widths.items()}
        self._make_room(pa.schema(kinds), part_rows)
        if after:
            self._go_on(after)

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
        bad = np.argwhere(~is_countable(rows))
        if not len(bad):
            super()._write()
            return
        row, column = bad[0]
        self._filled = int(row)
        super()._write()
        where = ", ".join(f"{key} {rows[row, COLUMN[key]]:.0f}" for key in INTEGERS)
        raise SimulationDiverged(f"{self._names[column]} is {uncountable_text(rows[row, column])}, at {where}")


def terms_of(trace: Log, begin: str = TERM) -> dict[str, NDArray[Any]]:
    """What each term of the reward paid, (rows,), by name; empty without columns that begin so."""
    return {name.removeprefix(begin): trace[name] for name in trace.columns if name.startswith(begin)}


def trace_of(columns: Columns, facts: EpisodeFacts = NOTHING_KNOWN) -> Log:
    """A trace in memory, as metrics get it.

    Args:
        columns: By their names in a trace, (rows, ...) each; without ``obstacle`` no step touched one.
        facts: What is known of the episodes.

    Raises:
        SchemaError: The columns have different numbers of rows.
    """
    trace = in_memory(TraceFacts(path=Path("trace"), format="trace", episodes=facts), columns)
    return _with_nothing_touched(trace, len(trace))


def paid_in(trace: Log | Columns, columns: Sequence[str] = PAID) -> Float:
    """What these columns paid together in each row, (rows,)."""
    paid: Float = np.sum([trace[name] for name in columns], axis=0)
    return paid


def mean_return(trace: Log, columns: Sequence[str] = PAID) -> float | None:
    """What a finished episode was paid in these columns together, mean over the episodes; None without one."""
    return mean_over_episodes(paid_in(trace, columns), trace)


def mean_over_episodes(values: Float, trace: Log) -> float | None:
    """The sum of `values`, one per row, over a finished episode, mean over the episodes; None without one."""
    sums = episode_sums(values, trace.episodes).tolist()
    return sum(sums) / len(sums) if sums else None


class Names(tuple[str, ...]):
    """Names of the columns of a trace, of which those who wrote for 0.2 expect the columns themselves."""

    __slots__ = ()

    def __getitem__(self, key: Any) -> Any:
        """The name at a place, or those of a slice.

        Raises:
            UsageError: `key` is a name; says what to write.
        """
        if isinstance(key, str):
            raise UsageError(f"log.columns has the names of the columns: write log['{key}'] for the column itself")
        return super().__getitem__(key)


def _with_nothing_touched(trace: Log, rows: int) -> Log:
    """The same trace; no step of one that does not say so touched an obstacle."""
    trace = replace(trace, columns=Names(trace.columns))
    return trace if OBSTACLE in trace else trace.add({OBSTACLE: np.broadcast_to(np.False_, rows)})


def require_rows(path: Path, count: int) -> None:
    """See that the first rows of a trace are there, so many of them; each number is read.

    Raises:
        SchemaError: They are not, or are damaged.
    """
    trace = read_trace(path)
    if (found := sum(len(piece["env"]) for piece in trace.pieces(trace.names))) < count:
        raise SchemaError(f"{path.name} has {found:,} rows, and {count:,} were written")


def read_trace(path: Path, after: int = 0, most: int | None = None) -> Log:
    """A trace, one that is being written too: as far as it was written. Each column is read when it is asked for.

    Args:
        path: The first of its files.
        after: Leave out so many of its files, which are full and were read before.
        most: Rows that it may have, of which it then has at least one; None for any number.

    Raises:
        SchemaError: The file is damaged, is no trace or was written by a newer version; or its end tells of another
            number of rows, or of a number that is too large. A column that is damaged raises it when it is read, and so
            does every column of a trace that was replaced by then, if it has several files.
    """
    paths = parts_of(path)[after:]
    parts = [_opened(part, MOST_NUMBERS // len(paths)) for part in paths]
    *full, (last, _, file) = parts
    told = file.metadata.metadata
    for part, _, one in full:
        if one.metadata.num_rows != PART_ROWS or one.metadata.metadata != told:
            raise SchemaError(f"{part} is no part of the trace that ends with {last.name}")
        one.close()
    with reading(last, "trace"):
        episodes = EpisodeFacts.from_bytes(told[FACTS_KEY]) if FACTS_KEY in told else NOTHING_KNOWN
    version, rows = told[FORMAT_KEY].decode(), len(full) * PART_ROWS + file.metadata.num_rows
    if most is not None and not 0 < rows <= most:
        raise SchemaError(f"{path} has {rows:,} rows, 1 to {most:,} are allowed")
    facts = TraceFacts(path=path, format=f"trace, format {version}", episodes=episodes)
    trace = Log(facts, tuple(filter(_is_known, file.schema_arrow.names)), partial(_tables, parts))
    if version == "1":
        trace = trace.add({"terminated": trace["ground"] | trace["reached"], "held": np.zeros(rows, bool)})
    return _with_nothing_touched(trace, rows)


class _Part(NamedTuple):
    """A file of a trace as it was when it was opened. The last one stays open: it may be written anew."""

    path: Path
    identity: tuple[int, int, int]
    """What one that takes its place has otherwise."""
    file: pq.ParquetFile


def _opened(path: Path, most: int) -> _Part:
    with reading(path, "trace"):
        part = _Part(path, _identity(path), open_parquet(path, PART_BYTES))
        version = (part.file.metadata.metadata or {}).get(FORMAT_KEY, b"none").decode()
        if version not in map(str, range(1, FORMAT + 1)):
            raise SchemaError(f"{path} is a trace of format {shortened(version, 20)}, this version reads 1 to {FORMAT}")
        schema = part.file.schema_arrow
        _require_columns(schema, ("reward", *(["ground", "reached"] if version == "1" else [])), path)
        for name, chunk in require_room(path, part.file, [*filter(_is_known, schema.names)], most):
            if chunk.least is not None and chunk.greatest is not None:
                _require_countable(chunk.least, chunk.greatest, f"{path}: {name}")
        return part


def _identity(path: Path) -> tuple[int, int, int]:
    told = path.stat()
    return told.st_ino, told.st_size, told.st_mtime_ns


def _tables(parts: Sequence[_Part], names: Sequence[str]) -> Iterator[Columns]:
    *full, last = parts
    for part in full:
        with open_part(part.path, "trace") as file:
            if _identity(part.path) != part.identity:
                raise SchemaError(f"{part.path} was replaced since it was opened: type the command again")
            yield from _rows(file, part.path, names)
    with reading(last.path, "trace"):
        yield from _rows(last.file, last.path, names)


def _rows(file: pq.ParquetFile, path: Path, names: Sequence[str]) -> Iterator[Columns]:
    for rows in rows_of(file, path, names):
        for name, values in rows.items():
            if values.dtype.kind == "f" and values.size:
                _require_countable(values.min(), values.max(), f"{path}: {name}")
        yield rows


def _is_known(column: str) -> bool:
    return column in (*SCALARS, *LISTS, *EXTRAS) or column.startswith(TERM)


def _require_columns(schema: pa.Schema, needed: Sequence[str], path: Path) -> None:
    if missing := [name for name in needed if name not in schema.names]:
        raise SchemaError(f"{path} has no column {', '.join(missing)}")
    for name in filter(_is_known, schema.names):
        found, number = schema.field(name).type, pa.float64()
        is_list = name in LISTS  # of any length
        expected = pa.list_(number, getattr(found, "list_size", 1)) if is_list else KINDS.get(name, number)
        if found != expected:
            raise SchemaError(f"{path} has a column {name} of {found}, not of {expected}")


def _require_countable(least: float, most: float, noun: str) -> None:
    if not (is_countable(least) and is_countable(most)):
        raise SchemaError(f"{noun} holds {UNCOUNTABLE}")


if not TYPE_CHECKING:
    __getattr__ = partial(lookup, __name__)
