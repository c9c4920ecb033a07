"""Writes the folder of a recorded training while it goes on: a part at a time, the last one anew every few seconds."""

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from filelock import FileLock, Timeout

from harness.errors import UsageError
from harness.log import Log
from harness.record.parts import RowsWriter
from harness.record.recording.facts import TrainingFacts, facts_of
from harness.record.recording.recorded_training import (
    INTEGERS,
    TICK,
    facts_name,
    first_part,
    part_schema,
    read_facts,
    read_recorder,
    recordings_in,
)
from harness.reward.steps import ENDS


class RecordingWriter(RowsWriter):
    """Writes the steps of one recorder; the columns of a row stand in the order of `part_schema`.

    Attributes:
        facts: Written with the next part; replace them to tell more.
        next_time: The time of the next row: 0, or what follows on the rows of a recording that goes on.
        next_episodes: (num_envs,), the same of each env's episode.
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
        super().__init__(first_part(folder, number))
        self.number, self.facts = number, facts
        self._written_facts: TrainingFacts | None = None
        self._lock = FileLock(folder / f"recording-{number}.lock")
        self._process = os.getpid()
        self.next_time = 0
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
                self._make_room(part_schema(facts))
            elif resume:
                self._resume()
            else:
                raise UsageError(
                    f"'{folder}' holds a recording already: name another path, or go on with it by resume=True. "
                    "Envs of one training that record into one path need numbers of their own, number=0, 1, 2 ..."
                )
            self._write()
        except BaseException:
            self._lock.release()
            raise

    def learn_terms(self, terms: Mapping[str, tuple[str, ...]]) -> None:
        """Make room for the terms of rewards, by name, before the first row; later ones have the same."""
        self.facts = replace(self.facts, terms=terms)
        self._make_room(part_schema(self.facts))

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

    def _resume(self) -> None:
        """Go on with what is there; a recording of an older version has the columns that it had."""
        before = read_facts(self.folder, self.number)
        now = self.facts
        _require_same_training(self.folder, before, now)
        for path in recordings_in(self.folder):
            if path != self.folder and (facts := read_facts(path)).evaluation and not facts.after:
                raise UsageError(
                    f"'{path}' evaluates the policy that the training in '{self.folder}' ended with. Without it the "
                    "training can go on"
                )
        self.facts = replace(
            before,
            closed=False,
            asked=now.asked or before.asked,  # whoever goes on may ask for more, and say what nobody had said
            lower_is_better=tuple(sorted({*before.lower_is_better, *now.lower_is_better})),
            higher_is_better=tuple(sorted({*before.higher_is_better, *now.higher_is_better})),
        )
        self._make_room(part_schema(self.facts))
        earlier = read_recorder(self.folder, self.number).rows((TICK, "env", "episode"))
        if len(earlier):
            self.next_time = int(earlier[TICK][-1]) + 1
            np.maximum.at(self.next_episodes, earlier["env"], earlier["episode"] + 1)
            self._go_on(len(earlier))

    def _files(self) -> dict[str, Callable[[Path], None]]:
        """The facts first: no reader finds NaN of which they do not tell."""
        files = super()._files() if self._filled else {}
        return files if self.facts is self._written_facts else {facts_name(self.number): self.facts.write, **files}

    def _write(self) -> None:
        super()._write()
        self._written_facts = self.facts


def write_recording(folder: Path, log: Log) -> None:
    """Write a whole training at once, as one recorder of number 0 would have recorded it; without its actions.

    Raises:
        UsageError: There is a recording in `folder` already.
        OSError: It cannot be written.
    """
    facts = replace(facts_of(log), actions=None)
    writer = RecordingWriter(folder, facts)
    try:
        rows = log.rows((TICK, *INTEGERS, *facts.numbers, *facts.term_columns, *ENDS)).columns
        writer.append(np.stack([*rows.values()], axis=1).astype(float))
    finally:
        writer.close()


def _require_same_training(folder: Path, before: TrainingFacts, now: TrainingFacts) -> None:
    for what in ("trained_with", "rewards", "behaviour", "num_envs", "spec", "sources", "horizon", "seed"):
        was, found = getattr(before, what), getattr(now, what)
        if was != found and not (what == "seed" and None in (was, found)):
            shown = f": {was!r}, now {found!r}" if what != "sources" else ""
            named = "env" if what == "spec" else what
            raise UsageError(
                f"'{folder}' holds the recording of another training: its {named} differ{shown}. Name another path"
            )
