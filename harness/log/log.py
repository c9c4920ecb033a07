"""What was kept of a training: named columns of rows, read in pieces or whole.

These names of columns mean the same in every log. `PATH` and `NAME` are any names; a log has those that it can tell.

=============================  =====================================================================================
env, episode, step             of a step: the env of a batch, the episode counted from 0 in each env, the step counted
                               from 0 (the start row, of logs that have one) or 1 in each episode
start                          whether the row is the start of an episode, before any step; it is paid nothing
terminated, truncated          whether the step ended the episode, or cut it
time                           environment steps of the training, over all its envs, that were taken when the row ended
length                         of an episode: its steps; of a point: the mean of some episodes'
reward/NAME                    what a reward paid for the row: a step's pay, an episode's return, a point's mean return.
                               ``reward/recorded`` where nobody says which reward it is
reward/NAME/TERM               what a term of it paid
behaviour/NAME                 a measure that no reward enters: after a step, of an episode, mean of a point
observation, observation/PATH  what was seen after the step
action, action/PATH            what was done in it
before/NAME                    any of these before the step, such as before/observation, where the log tells it itself
seen                           whether it is known what was seen after the step, where that is not so of every step; in
                               other rows an observation is NaN, or 0 in a column of whole numbers
info/NAME                      what the environment told after the step; NaN in rows of which it is not known
state/NAME                     what the simulator told after the step
operator, task, file           of data sets: who acted, what was to be done, and where the episode lies; text
=============================  =====================================================================================

A cell's trace has columns of its own names, see `harness.record.trace`.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.errors import SchemaError, UsageError
from harness.log.facts import LogFacts
from harness.reward.steps import nearest

Array: TypeAlias = NDArray[Any]
Columns: TypeAlias = Mapping[str, Array]
ROWS = 65_536
"""Rows of a piece: half a megabyte per number."""
MOST_ROWS = 200_000_000
"""The most rows that a log may have."""
LARGEST = 1e150
"""The largest number, whose square is still finite."""
REWARD, BEHAVIOUR, BEFORE, INFO = "reward/", "behaviour/", "before/", "info/"
OBSERVATION, ACTION, SEEN = "observation", "action", "seen"
OPERATOR, TASK, FILE = "operator", "task", "file"
RECORDED = "recorded"
"""The reward that a log's own column of pay holds, where nobody says which it is."""
SUCCESS = "success"
"""The measure that decides, where there is one of this name."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Consecutive rows of a log, of some of its columns.

    Attributes:
        columns: By name, (rows, ...) each.
        first: Number of the first row, counted from 0 in the log.
    """

    columns: Columns
    first: int = 0

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    def __getitem__(self, name: str) -> Array:
        """A column, (rows, ...).

        Raises:
            UsageError: It is not among them; says what is.
        """
        if name not in self.columns:
            raise missing_column(name, self.columns, "These rows have")
        return self.columns[name]

    def part(self, rows: slice | NDArray[np.int64] | NDArray[np.bool_]) -> "Rows":
        """Some of them, in order."""
        begins = rows.start or 0 if isinstance(rows, slice) else 0
        return Rows({name: values[rows] for name, values in self.columns.items()}, self.first + begins)


@dataclass(frozen=True, eq=False)
class Log:
    """What was kept of one training. Rows never change; a log that is being written has as many as there were by now.

    Attributes:
        facts: What is known beside the rows.
        columns: Names of the columns that there are.
        read: What a reader gives: of these columns the rows in order, in tables of any size. It is called anew for
            each pass, and holds no more than a table.
        added: Columns that were made later, such as what other rewards pay, (rows, ...) each.
    """

    facts: LogFacts
    columns: tuple[str, ...]
    read: Callable[[tuple[str, ...]], Iterable[Columns]]
    added: Columns = field(default_factory=dict)

    def pieces(self, columns: Iterable[str], rows: int = ROWS) -> Iterator[Rows]:
        """All rows in order, `rows` at a time, fewer only in the last piece; nothing else is held in memory.

        Args:
            columns: Which of them are read.
            rows: Of a piece.

        Raises:
            UsageError: The log does not have a column.
            SchemaError: It is damaged, or has more rows than are allowed.
        """
        first = 0
        for table in _regrouped((part.columns for part in self.tables(columns)), rows):
            yield Rows(table, first)
            first += len(next(iter(table.values())))

    def tables(self, columns: Iterable[str]) -> Iterator[Rows]:
        """The same in tables of any size, as the reader gives them. A column may have another shape in each of them.

        Raises:
            UsageError: The log does not have a column.
            SchemaError: It is damaged, or has more rows than are allowed.
        """
        names = tuple(dict.fromkeys(columns))
        for name in names:
            if name not in self.columns and name not in self.added:
                raise missing_column(name, self.names, f"{self.facts.path} has")
        own = tuple(name for name in names if name not in self.added) or self.columns[:1]
        first = 0
        for table in self.read(own):
            if len({len(values) for values in table.values()}) != 1:
                raise _uneven(self.facts, table)
            count = len(next(iter(table.values())))
            if first + count > MOST_ROWS:
                raise SchemaError(f"{self.facts.path} has more than the {MOST_ROWS:,} rows that are allowed")
            more = {name: self.added[name][first : first + count] for name in names if name in self.added}
            found = {**table, **more}
            yield Rows({name: found[name] for name in names}, first)
            first += count

    def rows(self, columns: Iterable[str] | None = None) -> Rows:
        """All rows at once, of some columns or of all; see `pieces`."""
        names = self.names if columns is None else tuple(dict.fromkeys(columns))
        parts = [piece.columns for piece in self.pieces(names)]
        if not parts:
            return Rows({name: np.empty(0) for name in names})
        return Rows({name: np.concatenate([part[name] for part in parts]) for name in names})

    def __getitem__(self, name: str) -> Array:
        """A whole column, (rows, ...). It is read once and kept."""
        if name not in self._held:
            self._held[name] = self.rows([name])[name]
        return self._held[name]

    def __contains__(self, name: object) -> bool:
        return name in self.columns or name in self.added

    def __len__(self) -> int:
        return len(self[self.names[0]])

    @property
    def names(self) -> tuple[str, ...]:
        """All columns, those that were added last."""
        return tuple(dict.fromkeys([*self.columns, *self.added]))

    @property
    def rewards(self) -> tuple[str, ...]:
        """Names of the rewards whose pay it tells."""
        return tuple(name.removeprefix(REWARD) for name in self.names if name.startswith(REWARD) and _is_whole(name))

    @property
    def measures(self) -> tuple[str, ...]:
        """Names of the measures that it tells, such as ``success``."""
        return tuple(name.removeprefix(BEHAVIOUR) for name in self.names if name.startswith(BEHAVIOUR))

    def terms_of(self, reward: str) -> tuple[str, ...]:
        """Names of the terms of a reward that it tells, in the order in which they are summed."""
        begin = f"{REWARD}{reward}/"
        return tuple(name.removeprefix(begin) for name in self.names if name.startswith(begin))

    def add(self, columns: Columns) -> "Log":
        """The same log with further columns, (rows, ...) each; one that it has already is replaced."""
        return replace(self, added={**self.added, **columns})

    @cached_property
    def _held(self) -> dict[str, Array]:
        return {}


def in_memory(facts: LogFacts, columns: Columns) -> Log:
    """A log whose columns are all there, (rows, ...) each.

    Raises:
        SchemaError: They have different numbers of rows.
    """
    log = Log(facts, tuple(columns), lambda names: [{name: columns[name] for name in names}])
    if len({len(values) for values in columns.values()}) > 1:
        raise _uneven(facts, columns)
    log._held.update(columns)
    return log


def missing_column(name: str, there: Iterable[str], begin: str) -> UsageError:
    """Says that there is no such column, and what there is."""
    names = list(there)
    return UsageError(f"No column '{name}'. {begin}: {', '.join(names)}{nearest(name, names)}")


def _is_whole(column: str) -> bool:
    """Whether a column of pay is a reward's, and none of its terms'."""
    return "/" not in column.removeprefix(REWARD)


def _uneven(facts: LogFacts, columns: Columns) -> SchemaError:
    told = ", ".join(f"{name} {len(values):,}" for name, values in columns.items())
    return SchemaError(f"{facts.path}: its columns have different numbers of rows: {told}")


def _regrouped(tables: Iterable[Columns], rows: int) -> Iterator[Columns]:
    """The same rows in tables of `rows` rows; the last one may be shorter."""
    waiting: list[Columns] = []
    held = 0
    for table in tables:
        held += len(next(iter(table.values())))
        waiting.append(table)
        if held >= rows:
            whole = _joined(waiting)
            ends = held - held % rows
            yield from (_part(whole, begin, begin + rows) for begin in range(0, ends, rows))
            waiting, held = [_part(whole, ends, held)], held - ends
    if held:
        yield _joined(waiting)


def _joined(tables: Sequence[Columns]) -> Columns:
    if len(tables) == 1:
        return tables[0]
    return {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}


def _part(table: Columns, begin: int, end: int) -> Columns:
    return {name: values[begin:end] for name, values in table.items()}
