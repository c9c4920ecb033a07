"""Writes the folder of a recorded training while it goes on: a part at a time, the last one anew every few seconds."""

import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from filelock import FileLock, Timeout

from harness.arrays import Float
from harness.errors import UsageError
from harness.files.bounded import whole_files
from harness.files.parquet import table_of, write_packed
from harness.log import Log
from harness.record.recording.facts import TrainingFacts, facts_of
from harness.record.recording.recorded_training import (
    FLAGS,
    INTEGERS,
    PART_ROWS,
    TICK,
    facts_name,
    part_name,
    part_schema,
    read_part,
    read_recorder,
)

Rows = Float | Sequence[Sequence[float]]
WRITE_EVERY, SOONEST = 4.0, 2.0
"""A training that is killed loses the steps of so many seconds at most, [s]; who watches it sees them as soon."""
LARGEST_SHARE = 0.005
"""Writing takes this share of the time at most where it is done more often than every `WRITE_EVERY`."""


class RecordingWriter:
    """Writes the steps of one recorder; the columns of a row stand in the order of `part_schema`.

    Attributes:
        facts: Written with the next part; replace them to tell more.
        next_time: The time of the next row: 0, or what follows on the rows of a recording that goes on.
        next_episodes: (num_envs,), the same of each env's episode.
        due: When the newest part is written again, by `time.monotonic`.
    """

    def __init__(self, folder: Path, facts: TrainingFacts, number: int = 0, resume: bool = False) -> None:
        """Start the recorder's files, or go on with them.

        Args:
            folder: Of the training; it is made.
            facts: What is known of it.
            number: Of this recorder in its training.
            resume: Go on if the recorder has files here already; otherwise that is refused.

        Raises:
            UsageError: It has files here and `resume` is false, or they are those of another training; or another
                recorder of the same number is at work.
            SchemaError: What is there is damaged.
            OSError: The folder cannot be written.
        """
        folder.mkdir(parents=True, exist_ok=True)
        self.folder, self.number, self.facts = folder, number, facts
        self._written_facts: TrainingFacts | None = None
        self._lock = FileLock(folder / f"recording-{number}.lock")
        self._process = os.getpid()
        self._part = self._filled = self.next_time = 0
        self.due = 0.0
        self.next_episodes = np.zeros(facts.num_envs, np.int64)
        try:
            self._lock.acquire(timeout=0)
        except Timeout:
            raise UsageError(
                f"'{folder}' is being recorded by another env with number={number}: envs of one training need numbers "
                "of their own, number=0, 1, 2 ...; another training needs another path"
            ) from None
        try:
            if not (folder / facts_name(number)).exists():
                self._make_room()
            elif resume:
                self._go_on()
            else:
                raise UsageError(
                    f"'{folder}' holds a recording already: name another path, or go on with it by resume=True. "
                    "Envs of one training that record into one path need numbers of their own, number=0, 1, 2 ..."
                )
            self._write()
        except BaseException:
            self._lock.release()
            raise

    def append(self, rows: Rows) -> None:
        """Take rows, (n, columns), which may be used again.

        Raises:
            OSError: They cannot be written.
        """
        while len(rows):
            taken = rows[: PART_ROWS - self._filled]
            self._block[self._filled : self._filled + len(taken)] = taken
            self._filled += len(taken)
            rows = rows[len(taken) :]
            if self._filled == PART_ROWS:
                self._write()
                self._part, self._filled = self._part + 1, 0
        if time.monotonic() >= self.due:
            self._write()

    def learn_terms(self, terms: Mapping[str, tuple[str, ...]]) -> None:
        """Make room for the terms of rewards, by name, before the first row; later ones have the same."""
        self.facts = replace(self.facts, terms=terms)
        self._make_room()

    @property
    def is_open(self) -> bool:
        """Whether it may still write: it was not closed, and this is the process that began, not a fork of it."""
        return os.getpid() == self._process and self._lock.is_locked

    def close(self) -> None:
        """Write what is left. Done twice, or in a fork of the process that began, it does nothing.

        Raises:
            OSError: It cannot be written.
        """
        if not self.is_open:
            return
        self.facts = replace(self.facts, closed=True)
        try:
            self._write()
        finally:
            self._lock.release()

    def _make_room(self) -> None:
        """For the rows of a part; a recording of an older version, which goes on, has the columns that it had."""
        self._schema = part_schema(self.facts)
        self._block = np.empty((PART_ROWS, len(self._schema)))

    def _go_on(self) -> None:
        before = TrainingFacts.read(self.folder / facts_name(self.number))
        _require_same_training(self.folder, before, self.facts)
        now, asked = self.facts, self.facts.asked or before.asked  # whoever goes on may ask for more
        better = now if now.lower_is_better or now.higher_is_better else before  # and say what nobody had said
        lower, higher = better.lower_is_better, better.higher_is_better
        self.facts = replace(before, closed=False, asked=asked, lower_is_better=lower, higher_is_better=higher)
        self._make_room()
        earlier = read_recorder(self.folder, self.number).rows((TICK, "env", "episode"))
        if len(earlier):
            self.next_time = int(earlier[TICK][-1]) + 1
            np.maximum.at(self.next_episodes, earlier["env"], earlier["episode"] + 1)
            self._part, self._filled = divmod(len(earlier), PART_ROWS)
        if self._filled:
            table = read_part(self.folder / part_name(self.number, self._part), self._schema)
            self._block[: self._filled] = np.stack([column.to_numpy() for column in table.columns], axis=1)

    def _write(self) -> None:
        """The facts first: no reader finds NaN of which they do not tell."""
        files, begun = dict[str, Callable[[Path], None]](), time.thread_time()
        if self.facts is not self._written_facts:
            files[facts_name(self.number)] = self.facts.write
        if self._filled:
            steps = table_of(self._block[: self._filled], self._schema)
            files[part_name(self.number, self._part)] = partial(write_packed, steps)
        # Without steps nothing would be lost, and beginning a training does not wait for the disk.
        with whole_files(self.folder, [*files], is_lasting=self._filled > 0) as partials:
            for path, write in zip(partials, files.values(), strict=True):
                write(path)
        self._written_facts = self.facts
        took = time.thread_time() - begun
        self.due = time.monotonic() + min(WRITE_EVERY, max(SOONEST, took / LARGEST_SHARE))


def write_recording(folder: Path, log: Log) -> None:
    """Write a whole training at once, as one recorder of number 0 would have recorded it; without its actions.

    Raises:
        UsageError: There is a recording in `folder` already.
        OSError: It cannot be written.
    """
    facts = replace(facts_of(log), actions=None)
    writer = RecordingWriter(folder, facts)
    try:
        rows = log.rows((TICK, *INTEGERS, *facts.numbers, *facts.term_columns, *FLAGS)).columns
        writer.append(np.stack([*rows.values()], axis=1).astype(float))
    finally:
        writer.close()


def _require_same_training(folder: Path, before: TrainingFacts, now: TrainingFacts) -> None:
    for what in ("trained_with", "rewards", "behaviour", "num_envs", "spec", "sources", "horizon"):
        was, found = getattr(before, what), getattr(now, what)
        if was != found:
            shown = f": {was!r}, now {found!r}" if what != "sources" else ""
            named = "env" if what == "spec" else what
            raise UsageError(
                f"'{folder}' holds the recording of another training: its {named} differ{shown}. Name another path"
            )
