"""What follows from the files of one recording, each thing computed once; see `harness.results.kept`."""

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np

from harness.arrays import Float
from harness.eta.rescaling import PayLine, line_of
from harness.files.bounded import reading
from harness.files.plain import Plain
from harness.log import Log
from harness.log.log import EPISODES, REWARD
from harness.record.recording.facts import OWN_SOURCE, TrainingFacts, facts_of, file_column, term_column
from harness.record.recording.recorded_training import (
    ACTION,
    CALLS,
    INTEGERS,
    TICK,
    TICK_IN_FILE,
    read_recording,
    recording_files,
)
from harness.record.store import CELLS
from harness.results.by_term import ByTerm, by_term
from harness.results.kept import Kept
from harness.results.recordings.episodes import Episodes, episodes_of
from harness.reward.steps import ENDS
from harness.score.weighted_recordings import weighed


@dataclass(frozen=True)
class Likeness(Plain):
    """What one recording says of that.

    Attributes:
        digest: SHA-256 of all of its steps; empty where every recorded number is the same in all steps, so that equal
            recordings would say nothing of the trainings.
        lines: Each two rewards, and what the second one paid over what the first one paid; None where that is no line.
        paid_alike: Rewards that are recorded as what the env pays, each with a reward that paid the same in all steps.
    """

    digest: str = ""
    lines: tuple[tuple[str, str, PayLine | None], ...] = ()
    paid_alike: tuple[tuple[str, str], ...] = ()

    def line(self, one: str, other: str) -> PayLine | None:
        """What the second of two rewards paid over what the first one paid."""
        return next((line for *both, line in self.lines if both == [one, other]), None)


def likeness_of(recording: Log) -> Likeness:
    """Compare the columns of a log of steps."""
    facts = facts_of(recording)
    rewards, sources = {name: recording[f"{REWARD}{name}"] for name in facts.rewards}, facts.sources
    own = [name for name in rewards if f"{REWARD}{name}" in sources and sources[f"{REWARD}{name}"].text == OWN_SOURCE]
    can_end = "terminated" not in recording or bool(recording["terminated"].any())
    return Likeness(
        _digest(recording),
        tuple(
            (one, other, line_of(rewards[one], rewards[other], can_end=can_end))
            for one, other in permutations(rewards, 2)
        ),
        tuple(
            (name, other)
            for name in own
            for other in rewards
            if other != name and np.allclose(rewards[name], rewards[other], rtol=1e-5, atol=1e-6)
        ),
    )


def _digest(recording: Log) -> str:
    """SHA-256 of the columns under the names that they have in files."""
    numbers = {file_column(name): recording[name] for name in facts_of(recording).numbers}
    if all((values == values[:1]).all() for values in numbers.values()):
        return ""
    digest = hashlib.sha256()
    place = {name: recording[name] for name in (*INTEGERS, *ENDS) if name in recording}
    whole = {TICK_IN_FILE: recording[TICK], **place} if TICK in recording else place
    for name, values in sorted({**whole, **numbers}.items()):
        digest.update(f"{name}\0{len(values)}\0".encode())
        digest.update(np.ascontiguousarray(values).data)
    return digest.hexdigest()


class RecordingResults:
    """The results of one recording. Every method raises SchemaError if it has to read a file that is damaged.

    The recording is held from the first method that needs its steps until `keep`.

    Attributes:
        path: Its folder.
    """

    def __init__(self, folder: Path, path: Path, weighed: Iterable[str] = ()) -> None:
        """Read nothing yet but what is kept.

        Args:
            folder: The folder that holds recordings: what is kept lies there.
            path: The folder of this one.
            weighed: Rewards with weights that other recordings were trained with, ``gentle:effort=5``: they pay this
                one too, if it has the terms.
        """
        self.path, self._weighed = path, tuple(weighed)
        self._kept = Kept(folder, _name_of(folder, path), path)
        self._held: Log | None = None

    @cached_property
    def facts(self) -> TrainingFacts:
        """What is known of it beside its steps, rewards that were paid later included."""
        return TrainingFacts.from_json(self._told["facts"], self.path)

    @property
    def log(self) -> Log:
        """Its steps, of which no column is read yet; rewards with other weights pay them as far as terms tell it."""
        return weighed(read_recording(self.path), self._weighed)

    @property
    def steps(self) -> int:
        """How many are recorded."""
        return int(self._told["steps"])

    @property
    def likeness(self) -> Likeness:
        """What its columns have in common."""
        return Likeness.from_json(self._told["likeness"])

    @property
    def episodes(self) -> Episodes:
        """All that ended."""
        numbers = self._kept.told("episodes", self._made_of, lambda: np.ravel(episodes_of(self._recording).numbers))
        facts = self.facts
        return Episodes.of(facts, numbers.reshape(1 + len(facts.numbers), -1))

    def paid_by(self, reward: str) -> Float:
        """What a reward pays for each step, (steps,)."""
        return self._kept.told(f"paid by {reward}", self._made_of, lambda: self._paid(reward)[f"{REWARD}{reward}"])

    def terms_paid(self, reward: str) -> ByTerm:
        """What each term of a reward paid; without terms of one that has none, or was given up on the way."""
        if not self.facts.terms.get(reward):
            return ByTerm({}, self.steps)
        told = self._kept.told(f"terms {reward}", self._made_of, lambda: terms_in(self._paid(reward), reward))
        self._kept.save()
        return ByTerm.again(*told)

    def keep(self) -> None:
        """Compute all of it, keep what is new, and drop the recording."""
        for reward in self.facts.rewards:
            self.paid_by(reward)
            self.terms_paid(reward)
        self._held = None
        self._kept.save()

    @cached_property
    def _told(self) -> dict[str, Any]:
        def tell() -> dict[str, Any]:
            recording = self._recording
            likeness = likeness_of(recording).to_json()
            return {"facts": facts_of(recording).to_json(), "steps": len(recording), "likeness": likeness}

        return self._kept.told("recording", self._made_of, tell)

    @cached_property
    def _made_of(self) -> list[str]:
        with reading(self.path, "recording of a training"):
            return [*(f"{name} {self._kept.digest(name)}" for name in recording_files(self.path)), *self._weighed]

    @property
    def _recording(self) -> Log:
        if self._held is None:
            log = read_recording(self.path)
            log.load(name for name in log.names if name not in {*CALLS, ACTION})
            self._held = weighed(log, self._weighed)
        return self._held

    def _paid(self, reward: str) -> Log:
        """The recording with what a reward paid; one that is not held is not read whole for it."""
        is_held = self._held is not None or reward in self._weighed
        return self._recording if is_held else read_recording(self.path)


def terms_in(recording: Log, reward: str) -> ByTerm:
    """What each term of a reward paid in a log of steps; without terms of one that was given up on the way."""
    columns = {name: term_column(reward, name) for name in facts_of(recording).terms.get(reward, ())}
    log = recording.add({}).load([*EPISODES, *columns.values()])
    log = log.add({name: np.zeros(len(log), bool) for name in EPISODES if name not in log})
    found = {name: log[column] for name, column in columns.items()}
    is_known = not any(np.isnan(values).any() for values in found.values())
    return by_term(found if is_known else {}, log.episodes, len(log))


def _name_of(folder: Path, path: Path) -> str:
    """What the results of a recording are kept as: a cell's are with those of the cell."""
    place = path.relative_to(folder)
    return (place.relative_to(CELLS) if place.is_relative_to(CELLS) else place).as_posix()
