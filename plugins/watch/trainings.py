"""What a live page shows of trainings, read from the folder of an experiment or of recordings. Nothing is written."""

import os
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Literal, TypeAlias, TypeVar

from harness.cli.progress import left_text
from harness.errors import HarnessError, SchemaError, UsageError, one_line
from harness.eta.laws import Better
from harness.log.log import SUCCESS
from harness.record import (
    MANIFEST,
    PLAN,
    TRACE,
    Cell,
    Store,
    partial_folder,
    read_manifest,
)
from harness.record.folder import TRAINING_RECORDING
from harness.record.plan_file import read_plan
from harness.record.recording.recorded_training import recordings_in
from harness.record.status import FolderStatus, read_status

from .blocks import BEHAVIOUR, Blocks
from .recorded import Recording, Trace

T = TypeVar("T")
State: TypeAlias = Literal["running", "done", "stopped", "failed"]
MOST = 24
"""The most trainings that are drawn: those that run, and the newest others."""
MEASURED_AFTER = 3.0
"""Seconds of a recording that are watched before its speed is known."""


@dataclass(frozen=True)
class Training:
    """One training, as it stands.

    Attributes:
        place: What trainings share that can be compared: environment or simulator, and algorithm.
        reward: That taught.
        name: What tells it from others of the same reward.
        state: Whether it goes on; ``stopped`` was killed, or ended before all of its steps.
        steps: Environment steps done.
        asked: How many there will be; 0 if nobody said.
        blocks: What its episodes came to.
        hint: What they hint at, a line.
        measure: The behaviour that is shown; empty if nothing measures it.
        is_share: Whether that is a share of episodes.
        better: Which values of it are; empty if nobody says it.
        note: Why it failed.
    """

    place: str
    reward: str
    name: str
    state: State
    steps: int
    asked: int
    blocks: Blocks | None = None
    hint: str = ""
    measure: str = ""
    is_share: bool = False
    better: Better = ""
    note: str = ""


@dataclass(frozen=True)
class Shown:
    """What there is to be shown.

    Attributes:
        news: How many trainings there are, and what they do; a sentence that seldom changes.
        left: How long the rest takes, a sentence; empty if that is not known.
        trainings: Those that are drawn, in an order that stays.
        others: How many have begun beside these.
        done: How many are done; what results depend on.
    """

    news: str
    left: str
    trainings: tuple[Training, ...]
    others: int
    done: int


def source_of(folder: Path) -> "ExperimentSource | RecordingsSource":
    """What lies in a folder.

    Raises:
        UsageError: Neither an experiment nor a recording.
    """
    if Store.is_experiment(folder):
        return ExperimentSource(folder)
    if next(recordings_in(folder), None) is None:
        Store.open(folder)  # says what it is not
    return RecordingsSource(folder)


def remembered(name: str, read: Callable[[Path], T]) -> Callable[[Path], T]:
    """What `read` gives of a folder, read again where the file `name` in it is another one."""
    kept = cache(lambda folder, *_: read(folder))

    def read_new(folder: Path) -> T:
        try:
            found = os.stat(folder / name)
        except OSError:
            return read(folder)  # says what is wrong
        return kept(folder, found.st_ino, found.st_size, found.st_mtime_ns)

    return read_new


class ExperimentSource:
    """An experiment: cells of an arm leave traces, those in environments recordings."""

    def __init__(self, folder: Path) -> None:
        self.folder, self._store = folder, Store(folder)
        self._plans, self._manifests = remembered(PLAN, read_plan), remembered(MANIFEST, read_manifest)
        self._ended: dict[str, Training] = {}
        self._recordings: dict[Path, Recording] = {}
        self._traces: dict[Path, Trace] = {}
        self._may_end_early = bool(self._store.read_plan().terms.looks)

    def look(self) -> Shown:
        status = read_status(self.folder, plan_in=self._plans, manifest_in=self._manifests)
        begun = [it for it in status.cells if it.status in STATES]
        drawn = (begun[index] for index in newest([it.status == "running" for it in begun]))
        trainings = tuple(self._training(it.cell, STATES[it.status], it.steps, it.reason) for it in drawn)
        seconds = status.seconds_left if status.is_in_use else None
        left = "" if seconds is None else f"{left_text(seconds, at_most=self._may_end_early).capitalize()}."
        return Shown(news_of(status), left, trainings, len(begun) - len(trainings), status.count("done"))

    def _training(self, cell: Cell, state: State, steps: int, reason: str) -> Training:
        found = self._ended.get(cell.id)
        if state == "done" and found is not None:
            return found
        named = f"seed {cell.seed}"
        plain = Training(f"{cell.place.label} · {cell.learner}", cell.reward.label, named, state, steps, cell.steps)
        if state == "failed":
            return replace(plain, note=reason)
        folder = self._store.cell_folder(cell)
        folder = folder if state == "done" else partial_folder(folder)
        made = self._recorded(plain, folder) if cell.is_in_environment else self._arm(plain, folder)
        if state == "done":
            self._ended[cell.id] = made
        return made

    def _arm(self, plain: Training, folder: Path) -> Training:
        """The training of an arm, by its trace."""
        plain, path = replace(plain, measure="success", is_share=True, better="higher"), folder / TRACE
        if not path.exists():  # nothing is written yet
            return plain
        try:
            trace = self._traces[path] = self._traces.get(path) or Trace(path)
            trace.look(plain.asked)
            return replace(plain, blocks=trace.blocks, hint=trace.hint)
        except SchemaError as error:
            return replace(plain, note=one_line(error))

    def _recorded(self, plain: Training, folder: Path) -> Training:
        """In an environment: the recording that the cell writes."""
        path = folder / TRAINING_RECORDING
        try:
            recording = self._recordings[path] = self._recordings.get(path) or Recording(path)
            return told_by(recording, plain)
        except (SchemaError, ValueError):  # nothing is recorded yet
            return plain
        finally:
            if plain.state == "done":
                self._recordings.pop(path, None)


STATES: dict[str, State] = {
    "running": "running",
    "done": "done",
    "interrupted": "stopped",
    "failed": "failed",
    "damaged": "failed",
}


class RecordingsSource:
    """Recordings that scripts of anybody write, at any depth of a folder."""

    def __init__(self, folder: Path, now: Callable[[], float] = time.monotonic) -> None:
        self.folder, self._now = folder, now
        self._recordings: dict[Path, Recording] = {}
        self._begun: dict[Path, tuple[float, int]] = {}

    def look(self) -> Shown:
        if not self.folder.is_dir():
            raise UsageError(f"No folder '{self.folder}' any more")
        trainings, evaluations, damaged = list[tuple[Recording, Training]](), 0, list[str]()
        for path in sorted(recordings_in(self.folder)):
            try:
                recording = self._recordings[path] = self._recordings.get(path) or Recording(path)
                if recording.facts.evaluation:
                    evaluations += 1
                else:
                    trainings.append((recording, self._training(recording)))
            except (HarnessError, OSError) as error:  # it may be gone by now
                damaged.append(one_line(error))
        states = [it.state for _, it in trainings]
        drawn = tuple(trainings[index][1] for index in newest([it == "running" for it in states]))
        told = counts_of(states.count, running="running", done="ended", stopped="stopped before the end")
        told += f", {counted(evaluations, 'evaluation')}" if evaluations else ""
        said = ". ".join([f"{counted(len(trainings), 'training')} recorded{told}", *damaged])
        return Shown(f"{said}.", self._left(trainings), drawn, len(trainings) - len(drawn), 0)

    def _training(self, recording: Recording) -> Training:
        is_open = recording.is_open  # before the look: who closes it meanwhile has said so by then
        recording.look()
        facts = recording.facts
        state: State = "done" if facts.closed else "running" if is_open else "stopped"
        below = recording.folder.relative_to(self.folder)
        seed = () if facts.seed is None else (f"seed {facts.seed}",)
        name = ", ".join((str(below) if below.parts else recording.folder.name, *seed))
        plain = Training(facts.env or "an environment without a name", facts.trained_with, name, state, 0, 0)
        return told_by(recording, plain)

    def _left(self, trainings: Iterable[tuple[Recording, Training]]) -> str:
        """By the speed since each was first seen; the slowest one counts."""
        found = []
        for recording, training in trainings:
            now, steps = self._now(), training.steps
            since, before = self._begun.setdefault(recording.folder, (now, steps))
            if training.state == "running" and training.asked > steps > before and now >= since + MEASURED_AFTER:
                found.append((training.asked - steps) / (steps - before) * (now - since))
        return f"{left_text(max(found)).capitalize()}." if found else ""


def told_by(recording: Recording, plain: Training) -> Training:
    """The training, with what its recording tells by now."""
    recording.look(plain.asked)
    means = recording.blocks.means[:, BEHAVIOUR]
    return replace(
        plain,
        steps=recording.steps,
        asked=plain.asked or recording.facts.asked,
        blocks=recording.blocks,
        hint=recording.hint,
        measure=recording.measure,
        is_share=recording.measure == SUCCESS and bool(((means >= 0.0) & (means <= 1.0)).all()),
        better=recording.better,
    )


def newest(is_running: Sequence[bool]) -> list[int]:
    """Which of the trainings are drawn: `MOST` of them, running ones and then the last ones; in their order."""
    ordered = sorted(range(len(is_running)), key=lambda it: (is_running[it], it), reverse=True)
    return sorted(ordered[:MOST])


def counted(number: int, noun: str) -> str:
    """A number of things, ``3 trainings``."""
    return f"{number:,} {noun}" + "s" * (number != 1)


def counts_of(count: Callable[[Any], int], **kinds: str) -> str:
    """How many there are of each kind, ``, 3 running``, in its word; a kind that is not there is left out."""
    return "".join(f", {count(kind):,} {word}" for kind, word in kinds.items() if count(kind))


def news_of(status: FolderStatus) -> str:
    """What the cells of an experiment do, in a sentence."""
    words = {it: it for it in ("failed", "damaged", "skipped")}
    told = counts_of(status.count, running="running", interrupted="stopped", **words, pending="waiting")
    begin = f"{status.count('done'):,} of {counted(len(status.cells), 'training')} done{told}."
    unfinished = status.count("pending") + status.count("interrupted")
    if not status.is_in_use and unfinished:
        return f"{begin} No run is using the folder: the same command goes on with the rest."
    return begin
