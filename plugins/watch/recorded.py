"""The episodes of trainings, read from what is being written: only what is new since the last time."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.authoring.commands import (
    FLAGS,
    INTEGERS,
    PAID,
    TERM,
    TICK_IN_FILE,
    facts_name,
    file_column,
    is_held,
    part_count,
    part_name,
    part_schema,
    parts_of,
    read_part,
    recorder_numbers,
    term_column,
    term_names,
    trace_part,
)
from harness.log import BEHAVIOUR, REWARD, SUCCESS, OpenEpisodes
from harness.record import TrainingFacts, paid_in

from .blocks import BEHAVIOUR as BEHAVIOUR_AT, OWN, Blocks


class Told(NamedTuple):
    """Rows of a training, (rows,) each; `times` grow. What is summed is pay, behaviour, and what each term paid."""

    times: NDArray[np.int64]
    env: NDArray[Any]
    episode: NDArray[Any]
    ends: NDArray[np.bool_]
    summed: Sequence[NDArray[Any]]
    steps: int
    """How many steps these are."""


Ended: TypeAlias = tuple[NDArray[np.int64], Float]
"""Episodes that have ended, in order: times of their last rows, (episodes,), and their sums, (episodes, numbers)."""


class Episodes:
    """The episodes of rows in parts. Parts that are full never change: each is read once.

    Attributes:
        steps: How many are recorded.
    """

    def __init__(self) -> None:
        self._seen: tuple[object, ...] = ()
        self._full, self._ended, self._last = 0, list[Ended](), list[Ended]()
        self._open: OpenEpisodes | None = None
        self.steps = 0

    def look(self, parts: Sequence[Path], read: Callable[[Path, int], Told]) -> None:
        """Read what is new.

        Args:
            parts: All there are.
            read: Gives the rows of a part, by the steps before it.

        Raises:
            SchemaError: It is damaged.
        """
        seen = (len(parts), *(path.stat().st_mtime_ns for path in parts[-1:]))
        if seen == self._seen:
            return
        if len(parts) <= len(self._ended):  # it began anew
            self._full, self._ended, self._open = 0, [], None
        for part in parts[len(self._ended) : -1]:
            self._open, ended, steps = self._after(read(part, self._full))
            self._ended, self._full = [*self._ended, ended], self._full + steps
        self._last, self.steps = [], self._full
        for part in parts[-1:]:
            _, ended, steps = self._after(read(part, self._full))
            self._last, self.steps = [ended], self._full + steps
        self._seen = seen

    def ended(self, terms: int) -> Ended:
        """All so far, of a reward with so many terms."""
        parts = [*self._ended, *self._last] or [(np.empty(0, np.int64), np.empty((0, OWN + terms)))]
        times, numbers = map(np.concatenate, zip(*parts, strict=True))
        return times, numbers

    def _after(self, told: Told) -> tuple[OpenEpisodes, Ended, int]:
        before = self._open or OpenEpisodes.none(len(told.summed))
        after, rows, sums = before.after(told.env, told.episode, told.ends, told.summed)
        return after, (told.times[rows], sums.T), told.steps


class Recorder:
    """The files of one recorder."""

    def __init__(self, folder: Path, number: int) -> None:
        self._folder, self._number = folder, number
        self.facts = TrainingFacts.read(folder / facts_name(number))
        self.episodes = Episodes()

    def look(self) -> None:
        """Read what is new.

        Raises:
            SchemaError: It is damaged.
        """
        self.facts = TrainingFacts.read(self._folder / facts_name(self._number))
        count = part_count(self._folder, self._number)
        parts = [self._folder / part_name(self._number, part) for part in range(count)]
        self.episodes.look(parts, self._part)

    def _part(self, path: Path, _: int) -> Told:
        facts, name = self.facts, self.facts.trained_with
        pay, *terms = summed = [file_column(f"{REWARD}{name}"), *(term_column(name, it) for it in terms_in(facts))]
        measure = measure_of(facts.behaviour)
        measured = [file_column(f"{BEHAVIOUR}{measure}")] if measure else []
        names = [TICK_IN_FILE, "env", "episode", *FLAGS, *summed, *measured]
        table = read_part(path, part_schema(facts), names)
        told: dict[str, NDArray[Any]] = {it: np.asarray(table.column(it).to_numpy()) for it in names}
        ends = np.logical_or.reduce([told[it] for it in FLAGS])
        did = np.where(ends, told[measured[0]] if measured else np.nan, 0.0)  # what an episode came to at its end
        sums = [told[pay], did, *(told[it] for it in terms)]
        return Told(told[TICK_IN_FILE], told["env"], told["episode"], ends, sums, len(table))


class Recording:
    """One recorded training, which may be going on.

    Attributes:
        folder: Of the recording.
        blocks: What its episodes came to.
        steps: How many are recorded.
    """

    def __init__(self, folder: Path) -> None:
        """Read nothing yet but what is known beside the steps.

        Raises:
            SchemaError: It is damaged.
        """
        self.folder = folder
        self._recorders: dict[int, Recorder] = {}
        self.steps, self.blocks = 0, Blocks.of((), *Episodes().ended(0))
        self._add_recorders()

    @property
    def facts(self) -> TrainingFacts:
        """The facts of the first recorder."""
        return self._recorders[min(self._recorders)].facts

    @property
    def is_open(self) -> bool:
        """Whether a process is recording it now."""
        return any(is_held(self.folder / f"recording-{number}.lock") for number in self._recorders)

    def look(self) -> None:
        """Read what is new.

        Raises:
            SchemaError: It is damaged.
            OSError: It is gone.
        """
        self._add_recorders()
        before = self.steps
        for recorder in self._recorders.values():
            recorder.look()
        self.steps = sum(recorder.episodes.steps for recorder in self._recorders.values())
        if self.steps != before:
            self.blocks = self._blocks()

    def _add_recorders(self) -> None:
        for number in recorder_numbers(self.folder):
            if number not in self._recorders:
                self._recorders[number] = Recorder(self.folder, number)

    def _blocks(self) -> Blocks:
        terms = terms_in(self.facts)
        ended = [recorder.episodes.ended(len(terms)) for recorder in self._recorders.values()]
        envs = sum(recorder.facts.num_envs for recorder in self._recorders.values())
        ticks, numbers = map(np.concatenate, zip(*ended, strict=True))
        order = np.argsort(ticks, kind="stable")
        return Blocks.of(terms, envs * (ticks[order] + 1), numbers[order])


def terms_in(facts: TrainingFacts) -> tuple[str, ...]:
    """The terms of the reward that taught."""
    return facts.terms.get(facts.trained_with, ())


def measure_of(measures: Sequence[str]) -> str:
    """The measure that is shown: success, or the first one; empty without one."""
    return SUCCESS if SUCCESS in measures else next(iter(measures), "")


class Trace:
    """The training of an arm by its trace, which may grow."""

    def __init__(self, path: Path) -> None:
        """Read nothing yet but the names of columns.

        Raises:
            SchemaError: It is damaged, or is not there.
        """
        self._path, self._episodes, self._terms = path, Episodes(), term_names(path)

    def look(self) -> Blocks:
        """Read what is new; gives what all episodes came to.

        Raises:
            SchemaError: It is damaged.
        """
        self._episodes.look(parts_of(self._path), self._part)
        steps, numbers = self._episodes.ended(len(self._terms))
        numbers[:, BEHAVIOUR_AT] = numbers[:, BEHAVIOUR_AT] > 0
        return Blocks.of(self._terms, steps, numbers)

    def _part(self, path: Path, before: int) -> Told:
        terms = [f"{TERM}{name}" for name in self._terms]
        rows = trace_part(path, [*INTEGERS, "reached", *FLAGS, *PAID, *terms])
        steps = before + np.cumsum(rows["step"] > 0)
        sums = [paid_in(rows), rows["reached"], *(rows[name] for name in terms)]
        ends = rows["terminated"] | rows["truncated"]
        return Told(steps, rows["env"], rows["episode"], ends, sums, int(np.count_nonzero(rows["step"])))
