"""Pays recorded trainings in environments by other weights of their recorded terms, without the code of a reward."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

from harness.arrays import Float
from harness.files.sums import making
from harness.log import Log
from harness.log.log import REWARD
from harness.record.recording.facts import Source, facts_of, term_column
from harness.record.recording.recorded_training import (
    read_recorder,
    read_recording,
    recorder_numbers,
    recordings_in,
)
from harness.record.recording.scores import Scores, read_scores, scores_name, write_scores
from harness.record.store import Store
from harness.score.weights import RecordedTerms, name_of, recorded_choice, weighted_label, weighted_pay


def recordings_of(folder: Path) -> list[Path]:
    """The recordings of an experiment's done cells, or those that lie in a folder at any depth."""
    if not Store.is_experiment(folder):
        return sorted(recordings_in(folder))
    store = Store.open(folder)
    done = [cell for cell in store.read_plan().cells if store.examine(cell).status == "done"]
    return [path for cell in done for path in sorted(recordings_in(store.cell_folder(cell)))]


def recorded_weights(text: str, paths: Iterable[Path]) -> str:
    """The label of a reward with weights, ``gentle:effort=0.05``, whose terms are recorded; empty if they are nowhere.

    Raises:
        UsageError: It names a term that the reward does not have, or what it gives is no weight.
        SchemaError: A recording is damaged.
    """
    for path in paths:
        for number in recorder_numbers(path):
            of_recorder = _Recorder.read(path, number)
            for found in of_recorder.recorded(text):
                return weighted_label(text, of_recorder.terms[found])
    return ""


def pay_by_weights(path: Path, label: str) -> int:
    """Pay one recording by a reward with other weights, in a column of its own and one for each term.

    Args:
        path: The folder of the recording.
        label: The reward, as `recorded_weights` tells it.

    Returns:
        How many steps were paid; 0 if they were before.

    Raises:
        UsageError: Its terms are not recorded there, or a recorded weight is 0.
        SchemaError: The recording is damaged.
        OSError: The scores cannot be written.
    """
    len(read_recording(path))  # raises an error if it is damaged
    recorders = [_Recorder.read(path, number) for number in recorder_numbers(path)]
    if all(label in it.terms for it in recorders):
        return 0
    found = [it.scored(label) for it in recorders]  # all of them before one is written
    for it, scores in zip(recorders, found, strict=True):
        place = path / scores_name(it.number)
        with making(place):
            write_scores(place, scores.with_earlier(it.earlier))
    return sum(len(it.log) for it in recorders)


class _Recorder(NamedTuple):
    """What one recorder of a recording left, with what was scored later."""

    log: Log
    number: int
    earlier: Scores | None

    @classmethod
    def read(cls, path: Path, number: int) -> "_Recorder":
        """Its facts and scores; its steps are read when they are asked for."""
        log = read_recorder(path, number)
        earlier = read_scores(path / scores_name(number), partial(len, log))
        return cls(earlier.added_to(log) if earlier else log, number, earlier)

    @property
    def terms(self) -> Mapping[str, tuple[str, ...]]:
        """The terms of each reward that has some, by its label."""
        return facts_of(self.log).terms

    def recorded(self, asked: str) -> list[str]:
        """The labels under which the terms of the reward of this name are recorded."""
        return [label for label in self.terms if name_of(label) == name_of(asked)]

    def scored(self, label: str) -> Scores:
        """The columns of a reward with other weights."""
        recorded = (
            RecordedTerms(recorded_choice(then), self.terms[then], partial(self._columns, then))
            for then in self.recorded(label)
        )
        then, paid = weighted_pay(label, recorded, "these trainings have")
        was, now = f"{REWARD}{then.label}", f"{REWARD}{label}"
        return Scores(
            {now: paid.total, **{term_column(label, name): values for name, values in paid.terms.items()}},
            (),
            {now: Source("", f"the recorded terms of {then.label}, weighted as {label}")},
            tuple(replace(it, column=now) for it in facts_of(self.log).failures if it.column == was),
        )

    def _columns(self, label: str) -> dict[str, Float]:
        told = self.log.rows(term_column(label, name) for name in self.terms[label])
        return {name: told[term_column(label, name)] for name in self.terms[label]}
