"""What is the same in recorded trainings: whole trainings, and rewards that differ in nothing but their scale."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import permutations
from typing import Any, Self

import numpy as np

from harness.eta.rescaling import PayLine, line_of
from harness.log import Log
from harness.log.log import REWARD
from harness.record.recording.facts import OWN_SOURCE, facts_of, file_column
from harness.record.recording.recorded_training import FLAGS, INTEGERS, TICK, TICK_IN_FILE


@dataclass(frozen=True)
class Likeness:
    """What one recording says of that.

    Attributes:
        digest: SHA-256 of all of its steps; empty where every recorded number is the same in all steps, so that equal
            recordings would say nothing of the trainings.
        lines: By each two rewards, what the second one paid over what the first one paid; None where that is no line.
        paid_alike: Rewards that are recorded as what the env pays, each with a reward that paid the same in all steps.
    """

    digest: str
    lines: Mapping[tuple[str, str], PayLine | None]
    paid_alike: frozenset[tuple[str, str]]

    def to_json(self) -> dict[str, Any]:
        """Plain data; `from_json` gives the same back."""
        lines = [[*names, line and line.to_json()] for names, line in self.lines.items()]
        return {"digest": self.digest, "lines": lines, "paid_alike": sorted(self.paid_alike)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """What `to_json` told, also after a way through JSON."""
        lines = {(one, other): line and PayLine.from_json(line) for one, other, line in data["lines"]}
        return cls(data["digest"], lines, frozenset((name, other) for name, other in data["paid_alike"]))


NOTHING_ALIKE = Likeness("", {}, frozenset())


def likeness_of(recording: Log) -> Likeness:
    """Compare the columns of a log of steps."""
    facts = facts_of(recording)
    rewards, sources = {name: recording[f"{REWARD}{name}"] for name in facts.rewards}, facts.sources
    own = [name for name in rewards if f"{REWARD}{name}" in sources and sources[f"{REWARD}{name}"].text == OWN_SOURCE]
    can_end = "terminated" not in recording or bool(recording["terminated"].any())
    return Likeness(
        _digest(recording),
        {
            (one, other): line_of(rewards[one], rewards[other], can_end=can_end)
            for one, other in permutations(rewards, 2)
        },
        frozenset(
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
    place = {name: recording[name] for name in (*INTEGERS, *FLAGS) if name in recording}
    whole = {TICK_IN_FILE: recording[TICK], **place} if TICK in recording else place
    for name, values in sorted({**whole, **numbers}.items()):
        digest.update(f"{name}\0{len(values)}\0".encode())
        digest.update(np.ascontiguousarray(values).data)
    return digest.hexdigest()
