"""Pays recorded trainings in environments by other weights of their recorded terms, without the code of a reward."""

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from harness.errors import UsageError
from harness.log import Log, in_memory
from harness.log.log import REWARD
from harness.record.cell import Cell
from harness.record.recording.facts import Source, TrainingFacts, facts_of, term_column
from harness.record.recording.recorded_training import (
    add_scores,
    read_recording,
    read_scored,
    recorder_numbers,
    recordings_in,
)
from harness.record.recording.scores import with_scores
from harness.record.store import Store
from harness.score.weights import label_by_terms, name_of, recorded_choice, reweighted


def recordings_of(folder: Path) -> dict[Path, Cell | None]:
    """The recordings of an experiment's done cells, each with its cell, or those that lie in a folder at any depth."""
    if not Store.is_experiment(folder):
        return dict.fromkeys(sorted(recordings_in(folder)))
    store = Store.open(folder)
    done = [cell for cell in store.read_plan().cells if store.examine(cell).status == "done"]
    return {path: cell for cell in done for path in sorted(recordings_in(store.cell_folder(cell)))}


def recorded_weights(text: str, paths: Iterable[Path]) -> str:
    """The label of a reward with weights, ``gentle:effort=0.05``, whose terms are recorded; empty if they are nowhere.

    Raises:
        UsageError: It names a term that the reward does not have, or what it gives is no weight.
        SchemaError: A recording is damaged.
    """
    logs = (_read(path, number) for path in paths for number in recorder_numbers(path))
    return label_by_terms(text, (it for log in logs for it in facts_of(log).terms.items()))


def weighed(log: Log, labels: Iterable[str]) -> Log:
    """The same, and what rewards with other weights pay its steps, ``gentle:effort=5``, as far as terms tell it."""
    for label in labels:
        if label not in facts_of(log).rewards and name_of(label) in facts_of(log).terms:
            with suppress(UsageError):
                log = with_scores(log, _by_terms(log, name_of(label), label))
    return log


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
    logs = {number: _read(path, number) for number in recorder_numbers(path)}
    if all(label in facts_of(log).terms for log in logs.values()):
        return 0
    add_scores(path, {number: _scored(log, label) for number, log in logs.items()})
    return sum(map(len, logs.values()))


def _read(path: Path, number: int) -> Log:
    """What one recorder of a recording left, its scores included."""
    return with_scores(*read_scored(path, number))


def _scored(log: Log, label: str) -> Log:
    """The columns of a reward with other weights."""
    told = f"these trainings have no columns of the terms of '{name_of(label)}': give its file, --plugin FILE"
    refused = UsageError(f"{told}, and it is called")
    for then in facts_of(log).terms:
        if name_of(then) == name_of(label):
            try:
                return _by_terms(log, then, label, f"the recorded terms of {then}, weighted as {label}")
            except UsageError as error:  # a term was recorded with the weight 0, and elsewhere perhaps with another
                refused = error
    raise refused


def _by_terms(log: Log, then: str, label: str, origin: str = "") -> Log:
    """The columns of a reward that pays what the terms of another one in the log pay, with other weights.

    Raises:
        UsageError: They do not tell what it pays.
    """
    facts, now = facts_of(log), f"{REWARD}{label}"
    columns = {name: term_column(then, name) for name in facts.terms[then]}
    told = log.rows(columns.values())
    paid = reweighted(label, recorded_choice(then), {name: told[it] for name, it in columns.items()})
    scored = TrainingFacts(
        rewards=(label,),
        trained_with=label,
        sources={now: Source("", origin)} if origin else {},
        failed=tuple(replace(it, column=now) for it in facts.failed if it.column == f"{REWARD}{then}"),
        terms={label: tuple(paid.terms)},
    )
    return in_memory(scored, {now: paid.total, **{term_column(label, it): of for it, of in paid.terms.items()}})
