"""A measure under two rewards, means over several places."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from harness.arrays import Float, Ints
from harness.eta.behaviour_change import Change, Quantity
from harness.eta.interval import (
    CONFIDENCE,
    ONE_SIDED,
    Bounds,
    Interval,
    cut_to,
    mean_bounds,
    of_difference,
    why_no_interval,
)
from harness.eta.verdict.question import LEAST_SEEDS, Question


@dataclass(frozen=True, eq=False)
class Together:
    """Means over places of one measure.

    A measure that is no share counts relative to its mean size in each place, under both rewards together. Seconds of
    a slow place would outweigh those of a quick one, and the test does not weigh them either. Then the baseline's mean
    over places is taken for 1, so that readers meet the change that they would compute. It has the sign of what was
    tested, and lies between the changes of the single places. Values of either sign have no such mean, and stay shares
    of their size.

    Attributes:
        measure: What is measured, the same in all places.
        question: The values of this measure alone, in its unit or relative.
        is_of_size: Whether values are shares of the mean size in their place, since they have either sign.
        confidence: That of the interval.
    """

    measure: Quantity
    question: Question
    is_of_size: bool = False
    confidence: float = CONFIDENCE

    @classmethod
    def of(cls, changes: Sequence[Change], confidence: float = CONFIDENCE) -> "Together":
        """Put the trainings of several places together.

        Args:
            changes: Of one measure, one for each place.
            confidence: That of the interval.
        """
        measure, alone = changes[0].measure, [[change] for change in changes]
        scales = np.array([[1.0 / size_of(change)] for change in changes])
        question = question_of(alone, scales)
        if measure.is_share:
            return cls(measure, question, confidence=confidence)
        base, known = abs(question.means[0]), question.values[question.known]
        if base > 0.0 and (known.min() >= 0.0 or known.max() <= 0.0):
            return cls(measure, question_of(alone, scales / base), confidence=confidence)
        return cls(measure, question, True, confidence)

    @property
    def name(self) -> str:
        """The name of the metric."""
        return self.measure.name

    @property
    def is_relative(self) -> bool:
        """Whether values are shares of the baseline's mean, or of a size, and not in the measure's unit."""
        return not self.measure.is_share

    @property
    def ends(self) -> Bounds:
        """What a value can be, mean over places."""
        low, high = self.question.ends[:, 0].mean(axis=0)
        return float(low), float(high)

    @property
    def baseline(self) -> float:
        """The mean over trainings and places under the baseline."""
        return self.question.means[0]

    @property
    def proposed(self) -> float:
        """The same under the proposed reward."""
        return self.question.means[1]

    @property
    def difference(self) -> float:
        """Proposed - baseline."""
        return self.proposed - self.baseline

    @property
    def places(self) -> int:
        """How many places."""
        return self.question.places

    @property
    def seeds(self) -> int:
        """The fewest trainings of a reward in a place."""
        return self.question.seeds

    @property
    def counts(self) -> tuple[int, int]:
        """How many trainings of each reward have a value, in all places."""
        one, other = (len(side) for side in self._all)
        return one, other

    @property
    def without(self) -> tuple[int, int]:
        """How many were begun and have none, in all places."""
        one, other = self._lost.sum(axis=1)
        return int(one), int(other)

    @property
    def failed(self) -> tuple[int, int] | None:
        """How many of them failed or left no value; None of other measures, see `Change.failed`."""
        failed = self.measure.count_failed(*self._all)
        return failed and (failed[0] + self.without[0], failed[1] + self.without[1])

    @property
    def low(self) -> float | None:
        """The lower end of the 95 % interval of proposed - baseline; None below three trainings in a place."""
        return self._interval and self._interval[0]

    @property
    def high(self) -> float | None:
        """The upper end."""
        return self._interval and self._interval[1]

    @property
    def likely(self) -> Interval | None:
        """See `Change.likely`."""
        if why_no_interval(self.seeds) or not self.question.has_ends(0):
            return None
        return self.question.bounds(0, ONE_SIDED)

    @property
    def most(self) -> tuple[float, float] | None:
        """See `Change.most`."""
        if why_no_interval(self.seeds) or not self.question.has_ends(0):
            return None
        ends = [(float(low), float(high)) for low, high in self.question.ends[:, 0]]
        (_, one), (_, other) = (
            mean_bounds(side, ends, lost=lost.tolist()) for side, lost in zip(self._of_places, self._lost, strict=True)
        )
        return one, other

    @property
    def spread(self) -> float | None:
        """The standard deviation of one training, as far as it counts for the mean; None below two in a place."""
        return self.question.error(0) * math.sqrt(self.seeds / 2.0) if self.seeds >= LEAST_SEEDS else None

    @cached_property
    def _of_places(self) -> tuple[list[Float], list[Float]]:
        """The values of each reward's trainings, by place."""
        values = self.question.values[..., 0]
        one, other = ([side[np.isfinite(side[:, at]), at] for at in range(side.shape[1])] for side in values)
        return one, other

    @property
    def _lost(self) -> Ints:
        """How many trainings of each reward were begun in each place and left no value, (2, places)."""
        lost: Ints = (self.question.begun & ~self.question.known[..., 0]).sum(axis=1)
        return lost

    @property
    def _all(self) -> tuple[Float, Float]:
        """The values of each reward's trainings."""
        one, other = (np.concatenate(side) for side in self._of_places)
        return one, other

    @cached_property
    def _interval(self) -> Interval | None:
        """The interval of proposed - baseline, cut to what that can be."""
        if why_no_interval(self.seeds):
            return None
        return cut_to(self.question.bounds(0, self.confidence), of_difference(self.ends))


def size_of(change: Change) -> float:
    """What values are divided by, so that places can be put together: 1 of a share, else the mean size."""
    return 1.0 if change.measure.is_share else change.size or 1.0


def seeds_of(changes: Sequence[Sequence[Change]]) -> list[int]:
    """All seeds of the trainings of changes, by place and measure, in order."""
    all_sides = (side for of_place in changes for change in of_place for side in (*change.trainings, *change.lost))
    return sorted({seed for side in all_sides for seed in side})


def question_of(changes: Sequence[Sequence[Change]], scales: Sequence[Sequence[float]] | Float) -> Question:
    """A question about the values of changes.

    Args:
        changes: By place and measure.
        scales: What the values of each are multiplied by.
    """
    seeds = seeds_of(changes)
    row = {seed: at for at, seed in enumerate(seeds)}
    values = np.full((2, len(seeds), len(changes), len(changes[0])), np.nan)
    begun = np.zeros((2, len(seeds), len(changes)), np.bool_)
    for place, of_place in enumerate(changes):
        for measure, change in enumerate(of_place):
            for side, of_side in enumerate(change.trainings):
                at = [row[seed] for seed in of_side]
                values[side, at, place, measure] = np.array(change.values[side]) * scales[place][measure]
                begun[side, [*at, *(row[seed] for seed in change.lost[side])], place] = True
    ends = np.array([[change.measure.ends for change in of_place] for of_place in changes])
    return Question.of(
        values, np.sort(ends * np.array(scales)[..., None], axis=2), begun
    )  # a negative scale swaps ends
