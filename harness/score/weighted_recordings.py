"""Pays recorded trainings in environments by other weights of their recorded terms, without the code of a reward."""

from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

from harness.arrays import Float
from harness.files.sums import making
from harness.log import Log
from harness.log.log import REWARD
from harness.record.recording.facts import Failure, Source, TrainingFacts, facts_of, term_column
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
            write_scores(place, scores if it.earlier is None else scores.with_earlier(it.earlier))
    return sum(it.steps for it in recorders)


class _Recorder(NamedTuple):
    """What one recorder of a recording left, and what was scored later."""

    log: Log
    number: int
    facts: TrainingFacts
    steps: int
    earlier: Scores | None

    @classmethod
    def read(cls, path: Path, number: int) -> "_Recorder":
        """Its facts and scores; its steps are read when they are asked for."""
        log = read_recorder(path, number)
        return cls(log, number, facts_of(log), len(log), read_scores(path / scores_name(number), partial(len, log)))

    @property
    def terms(self) -> dict[str, tuple[str, ...]]:
        """The terms of each reward that has some, by its label."""
        return {**self.facts.terms, **(self.earlier.terms if self.earlier else {})}

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
        columns: dict[str, Float] = {f"{REWARD}{label}": paid.total}
        columns |= {term_column(label, name): values for name, values in paid.terms.items()}
        failures = (*self.facts.failures, *(self.earlier.failures if self.earlier else ()))
        return Scores(
            columns,
            (),
            {f"{REWARD}{label}": Source("", f"the recorded terms of {then.label}, weighted as {label}")},
            tuple(_of(failure, label) for failure in failures if failure.column == f"{REWARD}{then.label}"),
        )

    def _columns(self, label: str) -> dict[str, Float]:
        names = {name: term_column(label, name) for name in self.terms[label]}
        scored = self.earlier.columns if self.earlier else {}
        if set(names.values()) <= scored.keys():
            return {name: scored[column] for name, column in names.items()}
        read = self.log.rows(names.values())
        return {name: read[column] for name, column in names.items()}


def _of(failure: Failure, label: str) -> Failure:
    return replace(failure, column=f"{REWARD}{label}")
