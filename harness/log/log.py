"""What was kept of a training: named columns of rows, read in pieces or whole.

These names of columns mean the same in every log. `PATH` and `NAME` are any names; a log has those that it can tell.

=============================  =====================================================================================
env, episode, step             of a step: the env of a batch, the episode counted from 0 in each env, the step counted
                               from 0 (the start row, of logs that have one) or 1 in each episode
start                          whether the row is the start of an episode, before any step; it is paid nothing
terminated, truncated          whether the step ended the episode, or cut it
time                           environment steps of the training, over all its envs, that were taken when the row ended
iteration                      of a point, instead of time where nobody says how many environment steps its counter
                               counts as one, such as updates of the learner
since                          of a point: steps before the first episode that its values average, in what ``time`` or
                               ``iteration`` counts; the same as that of an evaluation, NaN where nobody knows
seconds                        since the log was begun, by a clock, when the row ended
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

A log of steps has ``episode`` and ``step``, a log of episodes ``length`` or ``time``, a log of points ``time`` or
``iteration``. Each has a ``reward/NAME`` or a ``behaviour/NAME``. Rows are in order of time, and episodes count up by
one in each env; without ``env`` there is one. ``terminated`` and ``truncated`` are true only in the last row of an
episode. Where a log has both, one of them is true there; the last episode of an env may be unfinished. NaN says that
nobody knows; of pay, that it failed, or was NaN as the learner was told.

A cell's trace has columns of its own names, see `harness.record.trace`. A CSV file of an arm's steps has distances by
these names: ``begin_distance``, ``previous_best``, ``distance``, ``delta_distance``.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Ints, Mask
from harness.errors import SchemaError, UsageError
from harness.log.facts import LogFacts
from harness.reward.steps import ENDS, nearest
from harness.text import shortened

Array: TypeAlias = NDArray[Any]
Columns: TypeAlias = Mapping[str, Array]
ROWS = 65_536
"""Rows of a piece: half a megabyte per number."""
MOST_ROWS = 200_000_000
"""The most rows that a log may have."""
LARGEST = np.float64(1e150)
"""The largest number that is counted with: its square is finite."""
UNCOUNTABLE = f"a number that is not finite, or beyond {LARGEST:g}"
TIME, SINCE, START, REWARD, BEHAVIOUR = "time", "since", "start", "reward/", "behaviour/"
BEFORE, INFO = "before/", "info/"
OBSERVATION, ACTION, SEEN = "observation", "action", "seen"
OPERATOR, TASK, FILE = "operator", "task", "file"
EPISODES = ("env", "episode", *ENDS)
"""Columns of steps that tell where episodes begin and end."""
RECORDED = "recorded"
"""The reward that a log's own column of pay holds, where nobody says which it is."""
SUCCESS = "success"
"""The measure that decides, where there is one of this name."""


def is_countable(values: Any) -> Any:
    """Where numbers can be counted with, finite and within `LARGEST`: of an array a mask, of a number one flag.

    What a reward pays is such a number at every door. So is each number of a log that is known.
    """
    return abs(values) <= LARGEST  # a comparison with what is no number is false


def uncountable_text(value: float) -> str:
    """Such a number, as a message shows it."""
    return f"{value:g}, no number within {LARGEST:g}"


def are_flags(values: Any) -> bool:
    """Whether all are 0 or 1: what is so in every episode is a share of them."""
    return bool(np.isin(values, (0.0, 1.0)).all())


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
        require_columns("A row", self.columns, name)
        return self.columns[name]

    def __contains__(self, name: object) -> bool:
        return name in self.columns

    def part(self, rows: slice | Ints | Mask) -> "Rows":
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
        known: Columns in memory, (rows, ...) each: those that were made later, such as what other rewards pay, and
            those that were read and kept. They are not read again.
    """

    facts: LogFacts
    columns: tuple[str, ...]
    read: Callable[[tuple[str, ...]], Iterable[Columns]]
    known: dict[str, Array] = field(default_factory=dict)

    def pieces(self, columns: Iterable[str], rows: int = ROWS) -> Iterator[Rows]:
        """All rows in order, `rows` at a time, fewer only in the last piece; nothing else is held in memory.

        Args:
            columns: Which of them are read.
            rows: Of a piece.

        Raises:
            UsageError: The log does not have a column.
            SchemaError: It is damaged, or has more rows than are allowed.
        """
        waiting: list[Columns] = []
        held = first = 0
        for table in self.tables(columns):
            waiting.append(table.columns)
            held += len(table)
            if held >= rows:
                whole, ends = Rows(joined(waiting), first), held - held % rows
                yield from (whole.part(slice(begin, begin + rows)) for begin in range(0, ends, rows))
                waiting, held, first = [whole.part(slice(ends, None)).columns], held - ends, first + ends
        if held:
            yield Rows(joined(waiting), first)

    def tables(self, columns: Iterable[str]) -> Iterator[Rows]:
        """The same in tables of any size, as the reader gives them. A column may have another shape in each of them.

        Raises:
            UsageError: The log does not have a column.
            SchemaError: It is damaged, or has more rows than are allowed.
        """
        names = tuple(dict.fromkeys(columns))
        require_columns(self.facts.path, self.names, *names)
        own = tuple(name for name in names if name not in self.known)
        if not own:
            yield Rows({name: self.known[name] for name in names})
            return
        first = 0
        for table in self.read(own):
            rows = slice(first, first + _count(self.facts, table))
            if rows.stop > MOST_ROWS:
                raise SchemaError(f"{self.facts.path} has more than the {MOST_ROWS:,} rows that are allowed")
            yield Rows({name: self.known[name][rows] if name in self.known else table[name] for name in names}, first)
            first = rows.stop

    def rows(self, columns: Iterable[str] | None = None) -> Rows:
        """All rows at once, of some columns or of all; see `pieces`.

        A log that is being written stays as long as the first column that is kept.
        """
        names = tuple(self.names if columns is None else columns)
        found = joined([table.columns for table in self.tables(names)])
        count = len(next(iter(self.known.values()))) if self.known else None
        return Rows({name: found.get(name, np.empty(0))[:count] for name in names})

    def __getitem__(self, name: str) -> Array:
        """A whole column, (rows, ...). It is read once and kept."""
        if name not in self.known:
            self.known.update(self.rows([name]).columns)
        return self.known[name]

    def load(self, columns: Iterable[str] | None = None) -> "Log":
        """The log itself, with columns that are read in one pass and kept, or all; those that it lacks are left out."""
        asked = self.names if columns is None else columns
        self.known.update(self.rows(name for name in asked if name in self and name not in self.known).columns)
        return self

    def __contains__(self, name: object) -> bool:
        return name in self.columns or name in self.known

    def __len__(self) -> int:
        return len(next(iter(self.known.values())) if self.known else self[self.columns[0]])

    @property
    def names(self) -> tuple[str, ...]:
        """All columns, those that were added last."""
        return tuple(dict.fromkeys([*self.columns, *self.known]))

    @property
    def rewards(self) -> tuple[str, ...]:
        """Names of the rewards whose pay it tells."""
        paid = self._below(REWARD)
        return tuple(name for name in paid if not any(name.startswith(f"{other}/") for other in paid))

    @property
    def measures(self) -> tuple[str, ...]:
        """Names of the measures that it tells, such as ``success``."""
        return self._below(BEHAVIOUR)

    def terms_of(self, reward: str) -> tuple[str, ...]:
        """Names of the terms of a reward that it tells, in the order in which they are summed."""
        return self._below(f"{REWARD}{reward}/")

    def _below(self, begin: str) -> tuple[str, ...]:
        return tuple(name.removeprefix(begin) for name in self.names if name.startswith(begin))

    @cached_property
    def last_rows(self) -> Ints:
        """The row numbers of the ends of finished episodes, in the order of the rows; of a log of steps."""
        ended: Ints = np.flatnonzero(self["terminated"] | self["truncated"])
        return ended

    @cached_property
    def episodes(self) -> list[Ints]:
        """The row numbers of each finished episode in order, by env, its start row first; of a log of steps."""
        env, episode, *ends = map(self.load(EPISODES).__getitem__, EPISODES)
        return episode_rows(env, episode, np.logical_or(*ends))

    def without_starts(self) -> "Log":
        """The same log without the rows that are the start of an episode, which no step ends in."""
        if START not in self:
            return self

        def read(names: tuple[str, ...]) -> Iterator[Columns]:
            for piece in self.pieces((*names, START)):
                steps = piece.part(~piece[START].astype(bool))
                yield {name: steps[name] for name in names}

        return Log(self.facts, tuple(name for name in self.names if name != START), read)

    def renamed(self, new: Mapping[str, str]) -> "Log":
        """The same log, in which some columns have other names: `new` by the name that each has now.

        Raises:
            UsageError: Two columns would have one name.
        """
        old = {new.get(name, name): name for name in self.names}
        for name, other in new.items():
            if name in self and other != name and other in self and new.get(other, other) == other:
                raise UsageError(f"'{name}' cannot be called '{other}': {self.facts.path} has a column of that name")

        def read(names: tuple[str, ...]) -> Iterator[Columns]:
            for table in self.tables(old[name] for name in names):
                yield {name: table[old[name]] for name in names}

        failed = tuple(replace(it, column=new.get(it.column, it.column)) for it in self.facts.failed)
        return Log(replace(self.facts, failed=failed), tuple(old), read)

    def add(self, columns: Columns) -> "Log":
        """The same log with further columns, (rows, ...) each; one that it has already is replaced."""
        return replace(self, known={**self.known, **columns})

    def part(self, rows: slice | Ints | Mask) -> "Log":
        """Some rows of it, by their numbers or flags, in the order in which they are given."""
        return Log(self.facts, self.names, lambda names: [{name: self[name][rows] for name in names}])


def in_memory(facts: LogFacts, columns: Columns) -> Log:
    """A log whose columns are all there.

    Args:
        facts: What is known beside the rows.
        columns: By name, (rows, ...) each, in order of time; the log keeps these arrays, so do not change them.

    Raises:
        SchemaError: They have different numbers of rows, or a number is beyond all returns.
    """
    _count(facts, columns)
    for name, values in zip(columns, map(np.asarray, columns.values()), strict=True):
        if values.dtype.kind == "f" and len(beyond := values[~(is_countable(values) | np.isnan(values))]):
            raise SchemaError(f"{facts.path}: a value of {name} is {beyond[0]:g}, which is beyond all returns")
    return Log(facts, tuple(columns), lambda names: [{name: columns[name] for name in names}], dict(columns))


def episode_rows(env: Array, episode: Array, ended: Mask | None = None) -> list[Ints]:
    """Row numbers of each episode, by env and in order.

    Args:
        env: Of each row, (rows,).
        episode: Counted from 0 in each env.
        ended: Whether the row is the last of its episode, to leave out those that are not finished.
    """
    key = env.astype(np.int64) << 32 | episode
    order = np.argsort(key, kind="stable")
    parts = np.split(order, np.flatnonzero(np.diff(key[order])) + 1) if len(order) else []
    return parts if ended is None else [rows for rows in parts if ended[rows[-1]]]


def episode_sums(values: Array, episodes: Sequence[Ints], discount: float = 1.0) -> Float:
    """The sum of `values`, one per row, over each of some episodes, (episodes,).

    Args:
        values: (rows,).
        episodes: Row numbers of each.
        discount: Row t of an episode, counted from 0, is multiplied by discount^t.
    """
    if not episodes:
        return np.empty(0)
    return sums_from(np.cumsum([0, *map(len, episodes[:-1])]), values[np.concatenate(episodes)], discount)


def episode_sum(values: Array, discount: float = 1.0) -> float:
    """The same of one episode, whose rows are all of these."""
    return float(sums_from(np.zeros(1, np.int64), values, discount)[0])


def sums_so_far(values: Array) -> Float:
    """The same of its first steps: of none, of one, and so on, (steps + 1,); they are added one after the other."""
    return np.concatenate([[0.0], np.cumsum(values, dtype=np.float64)])


def sums_from(begins: Ints, values: Array, discount: float = 1.0) -> Float:
    """The same of episodes that follow one another, (episodes,); `begins` are the numbers of their first rows."""
    steps = np.asarray(values, np.float64)
    if discount != 1.0:
        steps = steps * discount ** (np.arange(len(steps)) - np.repeat(begins, np.diff(begins, append=len(steps))))
    # Behind a zero each has the bits of the sum of that episode alone.
    steps = np.insert(steps, begins, 0.0)
    sums: Float = np.add.reduceat(steps, begins + np.arange(len(begins)))
    return sums


@dataclass(frozen=True, eq=False)
class OpenEpisodes:
    """Sums over episodes that have not ended, of steps that come in pieces.

    They are added one after the other; `episode_sums` adds in pairs, as NumPy adds an array, so that the last bits of
    the two may differ. Whoever adds up an episode's pay uses one of the two.

    Attributes:
        keys: Which episodes, by env and then number, (episodes,).
        sums: Of each column, (columns, episodes).
    """

    keys: Ints
    sums: Float

    @classmethod
    def none(cls, columns: int) -> Self:
        """Before the first step."""
        return cls(np.empty(0, np.int64), np.empty((columns, 0)))

    def after(self, env: Array, episode: Array, ends: Array, columns: Sequence[Array]) -> tuple[Self, Ints, Float]:
        """What is open after more steps; which of these ended an episode; the sums over these, (columns, episodes).

        Args:
            env: Its number, of each step, (steps,).
            episode: The same of the episode in its env.
            ends: Whether the step is the last of its episode, (steps,).
            columns: What is added up, (steps,) each.
        """
        keys = np.concatenate([self.keys, env.astype(np.int64) << 32 | episode.astype(np.int64)])
        episodes, where = np.unique(keys, return_inverse=True)
        sums = np.empty((len(columns), len(episodes)))
        for place, values in enumerate(columns):
            sums[place] = np.bincount(where, np.concatenate([self.sums[place], values]), len(episodes))
        rows = np.flatnonzero(ends)
        ended = where[len(self.keys) :][rows]
        # An env has one open episode at most: its last one, if it has not ended.
        is_open = np.append(np.diff(episodes >> 32) != 0, True)[: len(episodes)]
        is_open[ended] = False
        return type(self)(episodes[is_open], sums[:, is_open]), rows, sums[:, ended]


def require_columns(where: object, names: Collection[str], *wanted: str) -> None:
    """See that there are columns that somebody named.

    Args:
        where: What an error begins with, such as the path.
        names: The columns that there are.
        wanted: Those that were named; empty texts are not looked for.

    Raises:
        UsageError: One is not there; says what is.
    """
    for name in wanted:
        if name and name not in names:
            there = shortened(", ".join(names), 160) or "none"
            raise UsageError(f"{where} has no '{name}'. It has: {there}{nearest(name, tuple(names))}")


def _count(facts: LogFacts, columns: Columns) -> int:
    """How many rows columns have, which is one number."""
    counts = {name: len(values) for name, values in columns.items()}
    if len({*counts.values()}) > 1:
        told = ", ".join(f"{name} {count:,}" for name, count in counts.items())
        raise SchemaError(f"{facts.path}: its columns have different numbers of rows: {told}")
    return next(iter(counts.values()), 0)


def joined(tables: Sequence[Columns]) -> Columns:
    """The rows of all tables, one after the other; they have the same columns."""
    if len(tables) <= 1:
        return tables[0] if tables else {}
    return {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}
