"""Somebody's recorded run, read piece by piece, and the meaning of its rows.

The experimenters' two programs wrote the same columns with different meanings:

* base line: t is empty; delta_distance is filled in the rows of episode starts only; prevBest is the value before
  the step;
* K2: t counts from 0, the row of the episode's start; delta_distance is filled everywhere; prevBest is the value
  after the step.

A row is read by what is filled in, not by a guess about its file, so that files of both joined together are read too:

* the best distance before the step is ``distance - delta_distance`` where delta_distance is filled, which is true of
  both programs, and prevBest where it is empty;
* the row of an episode's start has t = 0 where t is filled; where t is empty it has delta_distance filled, a reward
  of 0, and distance, prevBest and beginDistance all equal.

beginDistance can change inside an episode (a target that was touched is drawn again) and is read row by row.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.errors import UsageError
from harness.files.bounded import reading
from harness.record.trace import to_numpy
from harness.registry.choice import Choice
from harness.reward.row_steps import FIELDS, TOUCHED, targets_touched

Columns = dict[str, Float]

ROWS = 65_536
"""Rows of a chunk: half a megabyte per column."""
MOST_ROWS = 50_000_000
"""The most rows of a recording: eleven days without a pause at 50 a second."""
LARGEST = 1e150
"""The largest number, whose square is still finite."""
LARGEST_STEP = 2**53
"""The largest count, up to which floating-point numbers are exact."""

EVENTS = ("reward_ground", "reward_target", "reward_step")
COLUMNS = (
    "reward", *EVENTS, "step", "begin_distance", "previous_best", "prev_best", "distance", "delta_distance", "env",
)  # fmt: skip
"""What is read of a file. `previous_best`, this project's, is always the value before the step; `prev_best`, the
experimenters', is not."""


NO_FIELDS: Mapping[str, NDArray[Any]] = MappingProxyType({})


class Chunk(NamedTuple):
    """Consecutive rows of a recording; arrays of shape (rows,), or None where the file has none of it."""

    line: int
    """Where the first row stands in its file: the line of a CSV file, blank lines not counted; a trace's row from 1."""
    reward: Float
    """The shaped reward alone; 0 in the row of an episode's start."""
    event: Float | None = None
    """Sum of the event terms, paid on top."""
    start: Mask | None = None
    """Whether the row is an episode's start. None, as all that follow, if the file has no distances."""
    begin_distance: Float | None = None
    """Bd, [m]."""
    previous_best: Float | None = None
    """Pb, the smallest distance of the episode before the step, [m]."""
    distance: Float | None = None
    """d(t), end effector to target after the step, [m]."""
    delta_distance: Float | None = None
    """d(t) - Pb, [m]."""
    step: NDArray[np.int64] | None = None
    """t: 0 at an episode's start. It is counted from there if the file does not say it."""
    env: NDArray[np.int64] | None = None
    """The env among those that trained together; 0 if the file does not say it."""
    touched: Mask | None = None
    """Whether the target was reached and the next one set after the row; None if the file does not say it."""
    more: Mapping[str, NDArray[Any]] = NO_FIELDS
    """Those fields that were asked for and are recorded, (rows, ...) each."""


@dataclass(frozen=True)
class Recording:
    """One recorded run.

    Attributes:
        path: The file.
        columns: What it has of `COLUMNS`, those that are read; of a trace also `TOUCHED`.
        taught_by: The reward that paid it, if the manifest beside it says so.
        seed: The run's seed, if the manifest says so.
        fields: Those of `harness.reward.row_steps.FIELDS` that it has.
        terms: Those of the reward that paid it of which it has a column, in their order.
    """

    path: Path
    columns: tuple[str, ...]
    taught_by: Choice | None
    seed: int | None
    _batches: Callable[[Sequence[str]], Iterator[pa.RecordBatch]]
    _report: Callable[[str], UsageError]
    _first_line: int
    fields: tuple[str, ...] = ()
    terms: tuple[str, ...] = ()

    @property
    def declared_reward(self) -> str | None:
        """What paid it, as `harness.registry.choice.choose` takes it, if that is known."""
        return self.taught_by.label if self.taught_by else None

    @property
    def has_distances(self) -> bool:
        """Whether the run can be scored again."""
        return "distance" in self.columns

    @property
    def has_events(self) -> bool:
        """Whether the event terms are recorded."""
        return set(EVENTS) <= set(self.columns)

    def chunks(self, rows: int = ROWS, fields: Iterable[str] = ()) -> Iterator[Chunk]:
        """All rows in order, `rows` at a time, fewer only in the last chunk; nothing else is held in memory.

        Args:
            rows: Of a chunk.
            fields: Those of `fields` that are read too.

        Raises:
            UsageError: A row cannot be read, there is none, or there are too many; names file, line and column.
            SchemaError: The file is damaged.
        """
        line, counted = self._first_line, 0
        read = [name for name in self.fields if name in {*fields}]
        for table in _regroup(self._batches([column for name in read for column in FIELDS[name]]), rows):
            with reading(self.path, "recording"):
                columns = {name: table.column(name).to_numpy().astype(np.float64, copy=False) for name in self.columns}
                chunk = _read_chunk(columns, line, counted)
                more = {name: _field_of(table, name) for name in read}
            if chunk is None or not _is_finite(list(more.values())):
                raise self._report("a number is missing, not finite or too large")
            yield chunk._replace(more=more)
            line += len(chunk.reward)
            if line - self._first_line > MOST_ROWS:
                raise UsageError(f"{self.path} has more than the {MOST_ROWS:,} rows that are allowed")
            counted = 0 if chunk.step is None else int(chunk.step[-1])
        if line == self._first_line:
            raise UsageError(f"{self.path} has no rows")


def _field_of(table: pa.Table, name: str) -> NDArray[Any]:
    """A field of some rows, (rows, ...)."""
    columns = [to_numpy(table.column(column), column) for column in FIELDS[name]]
    return columns[0] if len(columns) == 1 else np.stack(columns, axis=1)


def _regroup(batches: Iterable[pa.RecordBatch], rows: int) -> Iterator[pa.Table]:
    """The same rows in tables of `rows` rows; the last one may be shorter."""
    waiting: list[pa.RecordBatch] = []
    count = 0
    for batch in batches:
        waiting.append(batch)
        count += batch.num_rows
        if count >= rows:
            table = pa.Table.from_batches(waiting)
            whole = count - count % rows
            yield from (table.slice(start, rows) for start in range(0, whole, rows))
            waiting, count = table.slice(whole).to_batches(), count - whole
    if count:
        yield pa.Table.from_batches(waiting)


def _read_chunk(columns: Columns, line: int, counted: int) -> Chunk | None:
    """The chunk of some rows; None if a row lacks a number that it needs. `counted` is the step of the row before."""
    if any((np.abs(column) > LARGEST).any() for column in columns.values()):
        return None
    reward = columns["reward"]
    event = np.sum([columns[name] for name in EVENTS], axis=0) if set(EVENTS) <= set(columns) else None
    needed = [reward] if event is None else [reward, event]
    if "distance" not in columns:
        return Chunk(line, reward, event) if _is_finite(needed) else None
    begin, distance = columns["begin_distance"], columns["distance"]
    best, delta = _before_step(columns)
    env = columns.get("env", np.zeros(len(reward)))
    told = columns.get("step", np.full(len(reward), np.nan))
    if not _is_finite([*needed, begin, distance, best, delta, env]):
        return None
    if any((np.abs(count) > LARGEST_STEP).any() for count in (env, told)):
        return None
    filled = np.isfinite(columns["delta_distance"]) if "delta_distance" in columns else np.ones(len(reward), bool)
    alike = filled & (reward == 0.0) & (distance == begin) & (best == begin)
    start = np.where(np.isnan(told), alike, told == 0.0)
    step = np.where(np.isnan(told), _count_steps(start, counted), told).astype(np.int64)
    flags = [columns[name] > 0.0 for name in TOUCHED if name in columns]
    touched = targets_touched(*flags) if flags else None
    return Chunk(line, reward, event, start, begin, best, distance, delta, step, env.astype(np.int64), touched)


def _before_step(columns: Columns) -> tuple[Float, Float]:
    """Pb before the step and d - Pb, by the rule at the top of this file."""
    distance, delta = columns["distance"], columns.get("delta_distance")
    best = columns.get("previous_best", columns.get("prev_best"))
    if delta is None:
        assert best is not None  # one of the two is there, or the distances are not read
        return best, distance - best
    if best is None:
        return distance - delta, delta
    empty = np.isnan(delta)
    before = best if "previous_best" in columns else np.where(empty, best, distance - delta)
    return before, np.where(empty, distance - before, delta)


def _count_steps(start: Mask, counted: int) -> NDArray[np.int64]:
    """Rows since the last start row, which is 0; `counted` rows before the first one."""
    row = np.arange(len(start))
    since: NDArray[np.int64] = row - np.maximum.accumulate(np.where(start, row, -1 - counted))
    return since


def _is_finite(columns: list[Float]) -> bool:
    return all(bool(np.isfinite(column).all()) for column in columns)


def choose_columns(there: Iterable[str]) -> tuple[str, ...]:
    """The columns that are read. Distances are read only if the run can be scored again with them."""
    names = set(there)
    best = names & {"previous_best", "prev_best", "delta_distance"}
    scorable = bool(best) and {"begin_distance", "distance"} <= names
    wanted = {"reward": True, **dict.fromkeys(EVENTS, set(EVENTS) <= names)}
    return tuple(name for name in COLUMNS if name in names and wanted.get(name, scorable))
