"""A recorded training by its finished episodes."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.eta.interval import Bounds, are_within
from harness.record.recording.facts import BEHAVIOUR, REWARD, TrainingFacts
from harness.record.recording.recorded_training import RecordedTraining

UNKNOWN = "not a number in some episodes"


class Part(NamedTuple):
    """What the episodes of a stretch of a training come to: means over these episodes."""

    episodes: int
    returns: Mapping[str, float | None]
    """By reward; None where there is none."""
    behaviour: Mapping[str, float | None]
    """By measure."""
    reasons: Mapping[str, str]
    """Why there is none, by the names of both."""


@dataclass(frozen=True, eq=False)
class Episodes:
    """The finished episodes of a recording, in the order in which they ended. All arrays are (episodes,).

    Attributes:
        last: Row of the last step of each, counted from 0.
        returns: By reward, the sum over the episode; NaN where the reward was given up.
        behaviour: By measure, the value in its last step; NaN where the measure was given up.
        reasons: By column of a reward or a measure that is not known: why.
    """

    last: NDArray[np.int64]
    returns: Mapping[str, Float]
    behaviour: Mapping[str, Float]
    reasons: Mapping[str, str]

    @property
    def numbers(self) -> Float:
        """All of its arrays, a row each, (1 + rewards + measures, episodes); `of` makes the same of them again."""
        return np.array([self.last, *self.returns.values(), *self.behaviour.values()], dtype=np.float64)

    @classmethod
    def of(cls, facts: TrainingFacts, numbers: Float) -> Self:
        """The episodes of a recording.

        Args:
            facts: What is known of it beside its steps.
            numbers: What `numbers` told of its episodes.
        """
        last, returns, behaviour = np.split(numbers, [1, 1 + len(facts.rewards)])
        return cls(
            last[0].astype(np.int64),
            dict(zip(facts.rewards, returns, strict=True)),
            dict(zip(facts.behaviour, behaviour, strict=True)),
            {
                failure.column: f"given up in step {failure.step:,} of episode {failure.episode:,}: {failure.reason}"
                for failure in facts.failures
            },
        )

    def part(self, begin: int, end: int) -> Part:
        """The episodes that ended in the rows from `begin` to `end`, the latter not included."""
        inside = slice(*np.searchsorted(self.last, [begin, end]).tolist())
        count = len(self.last[inside])
        sides = (
            {name: _mean(values[inside]) for name, values in side.items()} for side in (self.returns, self.behaviour)
        )
        returns, behaviour = sides
        missing = [*((REWARD, it) for it in returns if returns[it] is None)]
        missing += [(BEHAVIOUR, it) for it in behaviour if behaviour[it] is None]
        reasons = {
            name: self.reasons.get(f"{kind}{name}", UNKNOWN) if count else "no episode ended" for kind, name in missing
        }
        return Part(count, returns, behaviour, reasons)

    def knows(self, reward: str) -> bool:
        """Whether it is known what a reward paid all episodes."""
        return f"{REWARD}{reward}" not in self.reasons

    def without(self, reward: str, reason: str) -> "Episodes":
        """The same episodes, of which it is not known what a reward paid them."""
        returns = {**self.returns, reward: np.full(len(self.last), np.nan)}
        return replace(self, returns=returns, reasons={**self.reasons, f"{REWARD}{reward}": reason})

    def is_flag(self, measure: str) -> bool:
        """Whether a measure is 0 or 1 in every episode that has it: its mean is a share of episodes."""
        return bool(np.isin(self._known(measure), (0.0, 1.0)).all())

    def is_within(self, measure: str, bounds: Bounds) -> bool:
        """Whether a measure lies within bounds in every episode that has it."""
        known = self._known(measure)
        return not len(known) or are_within(known, bounds)

    def _known(self, measure: str) -> Float:
        values: Float = np.asarray(self.behaviour.get(measure, ()))
        return values[~np.isnan(values)]


def episodes_of(recording: RecordedTraining) -> Episodes:
    """The episodes of a recording; one that had not ended is left out."""
    ended = np.flatnonzero(recording.terminated | recording.truncated)
    most = int(recording.episode.max(initial=0)) + 1
    _, numbers = np.unique(recording.env.astype(np.int64) * most + recording.episode, return_inverse=True)
    returns = [np.bincount(numbers, values)[numbers[ended]] for values in recording.rewards.values()]
    behaviour = [values[ended] for values in recording.behaviour.values()]
    return Episodes.of(recording.facts, np.array([ended, *returns, *behaviour], dtype=np.float64))


def count_text(number: int, noun: str) -> str:
    """A number of things, ``3 episodes``."""
    return f"{number:,} {noun}" + "s" * (number != 1)


def cut_text(cut: int, episodes: int, horizon: int) -> str:
    """How many of the episodes of evaluations were cut at the horizon, in words."""
    return f"{cut:,} of {episodes:,} evaluation episodes were cut after {horizon:,} steps"


def _mean(values: Float) -> float | None:
    """None without any, and where one is not known."""
    if not len(values) or np.isnan(values).any():
        return None
    return float(values.mean())
