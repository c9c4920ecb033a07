"""The episodes of trainings, read from what is being written: only what is new since the last time."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness import Float, Ints, Mask
from harness.eta.laws import direction_of
from harness.log.log import BEHAVIOUR, REWARD, SUCCESS, OpenEpisodes, are_flags
from harness.record import TrainingFacts, read_trace
from harness.record.folder import parts_of
from harness.record.out_folder import is_held
from harness.record.recording.facts import term_column
from harness.record.recording.recorded_training import (
    INTEGERS,
    TICK,
    part_paths,
    read_facts,
    read_recorder,
    recorder_numbers,
)
from harness.record.trace import PAID, TERM, paid_in
from harness.results.under_way import hint_of, measure_of
from harness.reward.steps import ENDS

from .blocks import BEHAVIOUR as BEHAVIOUR_AT, OWN, PAY, Blocks


class Told(NamedTuple):
    """Rows of a training, (rows,) each; `times` grow. What is summed is pay, behaviour, and what each term paid."""

    times: Ints
    env: NDArray[Any]
    episode: NDArray[Any]
    ends: Mask
    summed: Sequence[NDArray[Any]]
    steps: int
    """How many steps these are."""


Ended: TypeAlias = tuple[Ints, Float]
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

    def look(self, parts: Sequence[Path], read: Callable[[int, int], Iterable[Told]]) -> None:
        """Read what is new.

        Args:
            parts: All there are.
            read: Gives the rows behind so many parts, which have so many steps, a part at a time.

        Raises:
            SchemaError: It is damaged.
        """
        seen = (len(parts), *(path.stat().st_mtime_ns for path in parts[-1:]))
        if seen == self._seen:
            return
        if len(parts) <= len(self._ended):  # it began anew
            self._full, self._ended, self._open = 0, [], None
        told = [*read(len(self._ended), self._full)]
        for part in told[:-1]:
            self._open, ended = self._after(part)
            self._ended, self._full = [*self._ended, ended], self._full + part.steps
        self._last, self.steps = [], self._full
        for part in told[-1:]:
            self._last, self.steps = [self._after(part)[1]], self._full + part.steps
        self._seen = seen

    def ended(self, terms: int) -> Ended:
        """All so far, of a reward with so many terms."""
        parts = [*self._ended, *self._last] or [(np.empty(0, np.int64), np.empty((0, OWN + terms)))]
        times, numbers = map(np.concatenate, zip(*parts, strict=True))
        return times, numbers

    def _after(self, told: Told) -> tuple[OpenEpisodes, Ended]:
        before = self._open or OpenEpisodes.none(len(told.summed))
        after, rows, sums = before.after(told.env, told.episode, told.ends, told.summed)
        return after, (told.times[rows], sums.T)


class Recording:
    """One recorded training, which may be going on.

    Attributes:
        folder: Of the recording.
        blocks: What its episodes came to.
        better: Which values of the behaviour are; empty if nobody says it.
        hint: What its episodes hint at; see `harness.results.under_way.hint_of`.
        steps: How many are recorded.
    """

    def __init__(self, folder: Path) -> None:
        """Read nothing yet but what is known beside the steps.

        Raises:
            SchemaError: It is damaged.
        """
        self.folder = folder
        self._episodes = defaultdict[int, Episodes](Episodes)
        self._recorders, self.steps = self._read_recorders(), 0
        self._say(0)

    @property
    def facts(self) -> TrainingFacts:
        """The facts of the first recorder."""
        return self._recorders[min(self._recorders)]

    @property
    def is_open(self) -> bool:
        """Whether a process is recording it now."""
        return any(is_held(self.folder / f"recording-{number}.lock") for number in self._recorders)

    def look(self, asked: int = 0) -> None:
        """Read what is new of a training of so many steps, if somebody said it.

        Raises:
            SchemaError: It is damaged.
            OSError: It is gone.
        """
        self._recorders, before = self._read_recorders(), self.steps
        for number, facts in self._recorders.items():
            self._episodes[number].look(part_paths(self.folder, number), partial(self._told, number, facts))
        self.steps = sum(it.steps for it in self._episodes.values())
        if self.steps != before:
            self._say(asked or self.facts.asked)

    def _read_recorders(self) -> dict[int, TrainingFacts]:
        return {it: read_facts(self.folder, it) for it in recorder_numbers(self.folder)}

    @property
    def measure(self) -> str:
        """The behaviour that is shown; empty if nothing measures it."""
        return measure_of(self.facts.behaviour)

    def _say(self, asked: int) -> None:
        terms, facts = terms_in(self.facts), self.facts
        ended = [it.ended(len(terms)) for it in (self._episodes or {0: Episodes()}).values()]
        envs = sum(facts.num_envs for facts in self._recorders.values())
        ticks, numbers = map(np.concatenate, zip(*ended, strict=True))
        order = np.argsort(ticks, kind="stable")
        steps, numbers = envs * (ticks[order] + 1), numbers[order]
        behaviour = numbers[:, BEHAVIOUR_AT]
        is_flag = are_flags(behaviour)
        self.better = direction_of(self.measure, facts.lower_is_better, facts.higher_is_better, is_flag=is_flag)
        self.hint = hint_of(steps, numbers[:, PAY], behaviour, self.measure, self.better, asked)
        self.blocks = Blocks.of(terms, steps, numbers)

    def _told(self, number: int, facts: TrainingFacts, after: int, _: int) -> Iterator[Told]:
        name, measure = facts.trained_with, measure_of(facts.behaviour)
        pay, *terms = summed = [f"{REWARD}{name}", *(term_column(name, it) for it in terms_in(facts))]
        measured = [f"{BEHAVIOUR}{measure}"] if measure else []
        log = read_recorder(self.folder, number, after)
        for rows in log.tables([TICK, "env", "episode", *ENDS, *summed, *measured]):
            ends = np.logical_or.reduce([rows[it] for it in ENDS])
            did = np.where(ends, rows[measured[0]] if measured else np.nan, 0.0)  # what an episode came to at its end
            sums = [rows[pay], did, *(rows[it] for it in terms)]
            yield Told(rows[TICK], rows["env"], rows["episode"], ends, sums, len(rows))


def terms_in(facts: TrainingFacts) -> tuple[str, ...]:
    """The terms of the reward that taught."""
    return facts.terms.get(facts.trained_with, ())


class Trace:
    """The training of an arm by its trace, which may grow.

    Attributes:
        blocks: What its episodes came to.
        hint: What they hint at; see `harness.results.under_way.hint_of`.
    """

    def __init__(self, path: Path) -> None:
        """Read nothing yet but the names of columns.

        Raises:
            SchemaError: It is damaged, or is not there.
        """
        self._path, self._episodes = path, Episodes()
        self._terms = [it.removeprefix(TERM) for it in read_trace(path).columns if it.startswith(TERM)]
        self._say(0)

    def look(self, asked: int) -> None:
        """Read what is new of a training of so many steps.

        Raises:
            SchemaError: It is damaged.
        """
        before = self._episodes.steps
        self._episodes.look(parts_of(self._path), self._told)
        if self._episodes.steps != before:
            self._say(asked)

    def _say(self, asked: int) -> None:
        steps, numbers = self._episodes.ended(len(self._terms))
        reached = numbers[:, BEHAVIOUR_AT] = numbers[:, BEHAVIOUR_AT] > 0
        self.blocks = Blocks.of(self._terms, steps, numbers)
        self.hint = hint_of(steps, numbers[:, PAY], reached.astype(float), SUCCESS, "higher", asked)

    def _told(self, after: int, before: int) -> Iterator[Told]:
        terms = [f"{TERM}{name}" for name in self._terms]
        for rows in read_trace(self._path, after).tables([*INTEGERS, "reached", *ENDS, *PAID, *terms]):
            steps = before + np.cumsum(rows["step"] > 0)
            sums = [paid_in(rows.columns), rows["reached"], *(rows[name] for name in terms)]
            count, ends = int(np.count_nonzero(rows["step"])), rows["terminated"] | rows["truncated"]
            yield Told(steps, rows["env"], rows["episode"], ends, sums, count)
            before += count
