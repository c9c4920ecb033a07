"""What the test says of questions that are asked together.

The statistic of a question is M, the largest absolute Welch t of the measures that decide. Its p is the share of all
ways to deal the labels in which M is at least as large as it was, or more where no spread can be seen (`least_p`).
Several rewards are corrected together (Westfall and Young 1993). Several places get one answer first, and single
places only where that stands.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from harness.arrays import Float
from harness.eta.verdict.least_p import least_p
from harness.eta.verdict.question import Question

LEVEL = 0.05
"""The chance of a false claim about the robot, in an experiment in which no reward does anything."""
MOST_SUBSETS_OF = 10
"""Up to so many places every set of them is tried; of more, single places count."""
ROUNDING = 1e-9
"""Statistics that differ by less, relatively, are the same: sums of floats in another order may differ so."""


@dataclass(frozen=True)
class Ruling:
    """What the test says of one question.

    Attributes:
        p: The p-value of this question alone; None if there are too few trainings for a test.
        corrected: The p-value that holds for all questions that were asked together.
        level: The question is decided where `corrected` is at most this.
        of_measures: The corrected p-value of each measure by itself, held against the largest of all of them.
        signs: 1 where a measure is better under the proposed reward, -1 where it is worse, 0 where it is the same.
        asked: How many questions were asked together.
        small: The margin that the difference is smaller than, where a plan of several looks ended the training for
            that; None where it did not.
        instead: Where another test decides, which: a sentence; else empty.
        has_plan: Whether a plan of looks says when to ask again. Then nobody has to be told how many seeds are too few.
        missing: How many trainings that were planned or begun have no value. Without them no test is made.
        is_floored: Whether `p` is larger than the share of dealt labels, because all trainings of one reward succeed
            or fail, see `harness.eta.verdict.least_p`.
        is_held: Whether this is one of several places, and not told because the answer over all of them is open.
    """

    p: float | None = None
    corrected: float | None = None
    level: float = LEVEL
    of_measures: tuple[float, ...] = ()
    signs: tuple[int, ...] = ()
    asked: int = 1
    small: float | None = None
    instead: str = ""
    has_plan: bool = False
    missing: int = 0
    is_floored: bool = False
    is_held: bool = False

    @property
    def is_decided(self) -> bool:
        """Whether the trainings differ by more than chance."""
        return self.corrected is not None and self.corrected <= self.level and self.sign != 0

    @property
    def decider(self) -> int:
        """Which measure says most: that with the smallest p, the first of several."""
        return int(np.argmin(self.of_measures)) if self.of_measures else 0

    @property
    def sign(self) -> int:
        """1 if the measure that says most is better under the proposed reward, -1 if it is worse."""
        return self.signs[self.decider] if self.signs else 0

    def passes(self, measure: int) -> bool:
        """Whether a measure passes by itself."""
        return self.is_decided and self.of_measures[measure] <= self.level and self.signs[measure] != 0

    @property
    def is_contrary(self) -> bool:
        """Whether one measure is better and another one worse, both by more than chance."""
        return len({self.signs[at] for at in range(len(self.signs)) if self.passes(at)}) > 1

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "p": self.p,
            "p_corrected": self.corrected,
            "level": self.level,
            "questions": self.asked,
            "is_decided": self.is_decided,
        }


class Family:
    """The statistics of questions that are asked together, in every way to deal the labels."""

    def __init__(self, questions: Sequence[Question]) -> None:
        """Compute them.

        Args:
            questions: All of them can be tested.
        """
        found = [question.statistics() for question in questions]
        self._sizes = [np.abs(it).max(axis=1) for it in found]
        self._seen = [it[0] for it in found]
        self._sorted = [np.sort(it) for it in self._sizes]
        self._least = [least_p(question) for question in questions]
        self._is_joint = len({question.layout.strata for question in questions}) == 1

    def rulings(self, level: float = LEVEL) -> list[Ruling]:
        """What the test says, corrected by Westfall and Young's step-down procedure.

        The questions share their ways to deal labels where they have as many trainings; else by Holm's procedure.
        """
        of_measures = [self._of_measures(at) for at in range(len(self._seen))]
        alone = [min(p) for p in of_measures]
        order = sorted(range(len(alone)), key=alone.__getitem__)
        corrected, found = 0.0, dict[int, Ruling]()
        for rank, at in enumerate(order):
            rest = order[rank:]
            corrected = max(corrected, self._corrected(rest, alone[at]))
            found[at] = Ruling(
                alone[at],
                corrected,
                level,
                tuple(max(corrected, self._corrected(rest, p)) for p in of_measures[at]),
                tuple(int(np.sign(t)) for t in self._seen[at]),
                len(alone),
                is_floored=alone[at] > self._p(at, self._sizes[at][0]),
            )
        return [found[at] for at in range(len(alone))]

    def _of_measures(self, at: int) -> list[float]:
        """The p-value of each measure of a question by itself."""
        dealt = [self._p(at, abs(t)) for t in self._seen[at]]
        return [max(p, float(least)) for p, least in zip(dealt, self._least[at], strict=True)]

    def _p(self, at: int, size: float) -> float:
        """The share of ways in which the statistic of a question is at least so large."""
        ordered = self._sorted[at]
        smaller = int(np.searchsorted(ordered, size - ROUNDING * ordered[-1]))
        return (len(ordered) - smaller) / len(ordered)

    def _corrected(self, rest: Sequence[int], p: float) -> float:
        """The chance that any of some questions has so small a p by itself."""
        if len(rest) == 1:
            return p
        if not self._is_joint:
            return min(1.0, len(rest) * p)
        reached = np.zeros(len(self._sizes[rest[0]]), np.bool_)
        for at in rest:
            ordered = self._sorted[at]
            larger = len(ordered) - round(p * len(ordered))  # of the sorted sizes, those from here on have this p
            if larger == 0:
                return 1.0
            # Equal sizes have the larger p of all of them: what lies as low as the one before is not so rare.
            reached |= self._sizes[at] > ordered[larger - 1] + ROUNDING * ordered[-1]
        return max(p, float(reached.mean()))


def rule(questions: Sequence[Question], level: float = LEVEL) -> list[Ruling]:
    """What the test says of each question; nothing of those that have too few trainings.

    Args:
        questions: Asked together, each in one place, or in several that get one answer.
        level: The chance that any of them is decided where the rewards do nothing.
    """
    testable = [at for at, question in enumerate(questions) if question.is_testable]
    rulings = dict(zip(testable, Family([questions[at] for at in testable]).rulings(level), strict=True))
    asked = len(testable)
    return [rulings.get(at, Ruling(level=level, asked=asked)) for at in range(len(questions))]


def rule_places(question: Question, whole: Ruling) -> list[Ruling]:
    """What the test says of single places. None of them is decided where the answer over all of them is not."""
    places = [question.in_places(np.array([place])) for place in range(question.places)]
    found = rule(places, whole.level)

    def through(p: float) -> float:
        return max(1.0 if whole.corrected is None else whole.corrected, min(1.0, whole.asked * p))

    return [
        it
        if it.corrected is None
        else replace(
            it,
            corrected=through(it.corrected),
            of_measures=tuple(map(through, it.of_measures)),
            asked=whole.asked * question.places,
            has_plan=whole.has_plan,
            is_held=not whole.is_decided,
        )
        for it in found
    ]


def opposed_in(whole: Ruling, places: Sequence[Ruling]) -> int:
    """In how many places the robot certainly does the opposite of what the answer over all of them says.

    Args:
        whole: The answer over all places.
        places: What `rule_places` says of each.
    """
    return sum(it.is_decided and it.sign == -whole.sign for it in places)


def better_in(question: Question, whole: Ruling) -> int:
    """In how many places at least the robot does better, or worse: as the answer over all of them says.

    All sets of places whose mean may show nothing are looked at. The places that are not in the largest such set are
    those in which something happens (a partial conjunction, Benjamini and Heller 2008); 0 where there is no answer.
    A set has the least p of its trainings, as a question about these places alone would have it.
    """
    if not whole.is_decided:
        return 0
    level = whole.level / 2.0 / whole.asked
    places = question.places
    if places > MOST_SUBSETS_OF:
        ordered = np.sort(_one_sided(question, np.eye(places), whole.sign, level))
        passed = np.maximum.accumulate((places - np.arange(places)) * ordered) <= level
        return int(passed.sum())
    subsets = np.array([[number >> place & 1 for place in range(places)] for number in range(1, 2**places)], float)
    p_values = _one_sided(question, subsets, whole.sign, level)
    open_sizes = subsets.sum(axis=1)[p_values > level]
    return places - int(open_sizes.max(initial=0))


def _one_sided(question: Question, subsets: Float, sign: int, level: float) -> Float:
    """The p-value of the mean over each set of places, towards one side, by the measure that says most, (subsets,).

    Above the level a least p would change nothing, so there is none.
    """
    reached, seen = np.zeros((len(subsets), question.values.shape[3])), None
    for some in question.subset_statistics(subsets):
        towards = sign * some
        seen = towards[0] if seen is None else seen
        reached += (towards.max(axis=2)[..., None] >= seen - ROUNDING * np.abs(seen)).sum(axis=0)
    p_values: Float = reached / len(question.deals)
    for at in np.flatnonzero(p_values.min(axis=1) <= level):
        least = least_p(question.in_places(np.flatnonzero(subsets[at]))) / 2.0  # it is of both sides
        p_values[at] = np.maximum(p_values[at], least)
    lowest: Float = p_values.min(axis=1)
    return lowest
