"""A measure under two rewards, means over several places."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from harness.arrays import Float
from harness.eta.behaviour_change import Change, Quantity
from harness.eta.interval import (
    CONFIDENCE,
    UNBOUNDED,
    UNSEEN,
    Bounds,
    Interval,
    binomial_variance,
    of_difference,
    quantile,
    why_no_interval,
)
from harness.eta.unseen import ONE_SIDED, difference_bounds, mean_bounds
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
    """

    measure: Quantity
    question: Question
    is_of_size: bool = False

    @classmethod
    def of(cls, changes: Sequence[Change]) -> "Together":
        """Put the trainings of several places together.

        Args:
            changes: Of one measure, one for each place.
        """
        measure, alone = changes[0].measure, [[change] for change in changes]
        scales = np.array([[1.0 / size_of(change)] for change in changes])
        question = question_of(alone, scales)
        if measure.is_share:
            return cls(measure, question)
        base, known = abs(question.means[0]), question.values[question.known]
        if base > 0.0 and (known.min() >= 0.0 or known.max() <= 0.0):
            return cls(measure, question_of(alone, scales / base))
        return cls(measure, question, is_of_size=True)

    @property
    def name(self) -> str:
        """The name of the metric."""
        return self.measure.name

    @property
    def is_relative(self) -> bool:
        """Whether values are shares of the baseline's mean, or of a size, and not in the measure's unit."""
        return not self.measure.is_share

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
    def seeds(self) -> int:
        """The fewest trainings of a reward in a place."""
        return self.question.seeds

    @property
    def counts(self) -> tuple[int, int]:
        """How many trainings of each reward there are in all places."""
        one, other = (len(side) for side in self._all)
        return one, other

    @property
    def failed(self) -> tuple[int, int] | None:
        """How many of them failed; None of other measures, see `Change.failed`."""
        return self.measure.count_failed(*self._all)

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
        """See `Change.likely`. A seed may end alike in several places: the interval over seeds counts too."""
        if why_no_interval(self.seeds):
            return None
        low, high = difference_bounds(*self._of_places, [self._ends] * self.question.places)
        estimate = self.question.estimate
        reach = quantile(ONE_SIDED, estimate.freedom) * estimate.error
        return min(low, self.difference - reach), max(high, self.difference + reach)

    @property
    def most(self) -> tuple[float, float] | None:
        if why_no_interval(self.seeds):
            return None
        (_, one), (_, other) = (mean_bounds(side, [self._ends] * len(side)) for side in self._of_places)
        return one, other

    @property
    def spread(self) -> float | None:
        """The standard deviation of one training, as far as it counts for the mean; None below two in a place."""
        return math.sqrt(self._variance * self.seeds / 2.0) if self.seeds >= LEAST_SEEDS else None

    @property
    def _ends(self) -> Bounds:
        """What a value can be."""
        return UNBOUNDED if self.is_relative else self.measure.ends

    @cached_property
    def _of_places(self) -> tuple[list[Float], list[Float]]:
        """The values of each reward's trainings, by place."""
        values = self.question.values[..., 0]
        one, other = ([side[np.isfinite(side[:, at]), at] for at in range(side.shape[1])] for side in values)
        return one, other

    @property
    def _all(self) -> tuple[Float, Float]:
        """The values of each reward's trainings."""
        one, other = (np.concatenate(side) for side in self._of_places)
        return one, other

    @cached_property
    def _variance(self) -> float:
        """The variance of the difference of both means.

        Of a share it allows for trainings that were not seen, see `harness.eta.interval.share_variance`: one of each
        reward in one of the places, so the more places there are, the less it counts.
        """
        seen = self.question.estimate.error**2
        if self.measure.episodes is None:
            return seen
        places, floor, unseen = self.question.places, 0.0, 0.0
        for side in self._of_places:
            floor += sum(binomial_variance(float(of.mean()), self.measure.episodes) / len(of) for of in side)
            unseen += (UNSEEN / min(map(len, side))) ** 2 / places
        seen = max(seen, floor / places**2)
        return max(seen, seen * (1.0 - 1.0 / self.seeds) + unseen)

    @cached_property
    def _interval(self) -> Interval | None:
        """The 95 % interval of proposed - baseline, cut to what that can be."""
        if why_no_interval(self.seeds):
            return None
        reach = quantile(CONFIDENCE, self.question.estimate.freedom) * math.sqrt(self._variance)
        low, high = of_difference(self._ends)
        middle = self.difference
        return max(middle - reach, min(low, middle)), min(middle + reach, max(high, middle))


def size_of(change: Change) -> float:
    """What values are divided by, so that places can be put together: 1 of a share, else the mean size."""
    return 1.0 if change.measure.is_share else change.size or 1.0


def seeds_of(changes: Sequence[Sequence[Change]]) -> list[int]:
    """All seeds of the trainings of changes, by place and measure, in order."""
    return sorted({seed for of_place in changes for change in of_place for side in change.trainings for seed in side})


def question_of(changes: Sequence[Sequence[Change]], scales: Sequence[Sequence[float]] | Float) -> Question:
    """A question about the values of changes.

    Args:
        changes: By place and measure.
        scales: What the values of each are multiplied by.
    """
    seeds = seeds_of(changes)
    row = {seed: at for at, seed in enumerate(seeds)}
    values = np.full((2, len(seeds), len(changes), len(changes[0])), np.nan)
    for place, of_place in enumerate(changes):
        for measure, change in enumerate(of_place):
            for side, of_side in enumerate(change.trainings):
                at = [row[seed] for seed in of_side]
                values[side, at, place, measure] = np.array(change.values[side]) * scales[place][measure]
    ends = np.array([[change.measure.ends for change in of_place] for of_place in changes])
    return Question.of(values, np.sort(ends * np.array(scales)[..., None], axis=2))  # a negative scale swaps them
