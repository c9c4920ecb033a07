"""The episodes of trainings, read from what is being written: of a recording only what is new since the last time."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.authoring.commands import (
    FLAGS,
    TICK_IN_FILE,
    Blocks,
    facts_name,
    file_column,
    is_held,
    part_count,
    part_name,
    part_schema,
    read_part,
    recorder_numbers,
    term_column,
    terms_of,
)
from harness.log import BEHAVIOUR, REWARD, SUCCESS, OpenEpisodes
from harness.record import TrainingFacts, paid_in, read_trace


class Ended(NamedTuple):
    """Episodes that have ended, in order."""

    ticks: NDArray[np.int64]
    """How often the recorder had been stepped before the last step of each, (episodes,)."""
    numbers: Float
    """The numbers of each as `Blocks` has them, (episodes, numbers)."""


class Recorder:
    """The files of one recorder. Parts that are full never change: each is read once."""

    def __init__(self, folder: Path, number: int) -> None:
        self._folder, self._number = folder, number
        self._seen: tuple[object, ...] = ()
        self._read, self._full, self._ended = 0, 0, list[Ended]()
        self._open: OpenEpisodes | None = None
        self._last: list[Ended] = []
        self.facts = TrainingFacts.read(folder / facts_name(number))
        self.steps = 0

    def look(self) -> None:
        """Read what is new.

        Raises:
            SchemaError: It is damaged.
        """
        told, count = self._folder / facts_name(self._number), part_count(self._folder, self._number)
        newest = self._folder / part_name(self._number, max(count - 1, 0))
        seen = (count, *(path.stat().st_mtime_ns for path in (told, newest) if path.exists()))
        if seen == self._seen:
            return
        self.facts = TrainingFacts.read(told)
        while self._read < count - 1:
            self._open, ended, steps = self._part(self._read)
            self._ended.append(ended)
            self._read, self._full = self._read + 1, self._full + steps
        self._last, self.steps = [], self._full
        if count:
            _, ended, steps = self._part(count - 1)
            self._last, self.steps = [ended], self._full + steps
        self._seen = seen

    @property
    def ended(self) -> Ended:
        """All episodes so far."""
        parts = [*self._ended, *self._last]
        if not parts:
            return Ended(np.empty(0, np.int64), np.empty((0, 2 + len(terms_in(self.facts)))))
        return Ended(np.concatenate([it.ticks for it in parts]), np.concatenate([it.numbers for it in parts]))

    def _part(self, part: int) -> tuple[OpenEpisodes, Ended, int]:
        facts, name = self.facts, self.facts.trained_with
        summed = [file_column(f"{REWARD}{name}"), *(term_column(name, it) for it in terms_in(facts))]
        measure = measure_of(facts.behaviour)
        measured = [file_column(f"{BEHAVIOUR}{measure}")] if measure else []
        names = [TICK_IN_FILE, "env", "episode", *FLAGS, *summed, *measured]
        table = read_part(self._folder / part_name(self._number, part), part_schema(facts), names)
        told: dict[str, NDArray[Any]] = {it: np.asarray(table.column(it).to_numpy()) for it in names}
        before, ends = self._open or OpenEpisodes.none(len(summed)), np.logical_or.reduce([told[it] for it in FLAGS])
        after, rows, sums = before.after(told["env"], told["episode"], ends, [told[it] for it in summed])
        did = told[measured[0]][rows] if measured else np.nan
        return after, Ended(told[TICK_IN_FILE][rows], np.insert(sums, 1, did, axis=0).T), len(table)


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
        self.steps, self.blocks = 0, Blocks.none()
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
        self.steps = sum(recorder.steps for recorder in self._recorders.values())
        if self.steps != before:
            self.blocks = self._blocks()

    def _add_recorders(self) -> None:
        for number in recorder_numbers(self.folder):
            if number not in self._recorders:
                self._recorders[number] = Recorder(self.folder, number)

    def _blocks(self) -> Blocks:
        ended = [recorder.ended for recorder in self._recorders.values()]
        envs = sum(recorder.facts.num_envs for recorder in self._recorders.values())
        ticks = np.concatenate([it.ticks for it in ended])
        numbers = np.concatenate([it.numbers for it in ended])
        order = np.argsort(ticks, kind="stable")
        return Blocks.none(terms_in(self.facts)).followed_by(envs * (ticks[order] + 1), numbers[order])


def terms_in(facts: TrainingFacts) -> tuple[str, ...]:
    """The terms of the reward that taught."""
    return facts.terms.get(facts.trained_with, ())


def measure_of(measures: Sequence[str]) -> str:
    """The measure that is shown: success, or the first one; empty without one."""
    return SUCCESS if SUCCESS in measures else next(iter(measures), "")


def blocks_of_trace(path: Path) -> Blocks:
    """What the episodes of an arm's training came to, by its trace.

    Raises:
        SchemaError: It is damaged.
    """
    trace = read_trace(path)
    terms = terms_of(trace)
    values = [paid_in(trace), trace["reached"], *terms.values()]
    ends = trace["terminated"] | trace["truncated"]
    _, rows, sums = OpenEpisodes.none(len(values)).after(trace["env"], trace["episode"], ends, values)
    sums[1] = sums[1] > 0
    steps: NDArray[np.int64] = np.cumsum(trace["step"] > 0, dtype=np.int64)
    return Blocks.none(tuple(terms)).followed_by(steps[rows], sums.T)
