"""What the tests say of questions that are asked together: two strengths of a word, and one rule for each.

A *plain* word, helps or hurts, is said where the bound of a measure that decides leaves out 0: it allows for one
training more than were seen, at the end where it speaks most against the word (`Question.bounds`). *Ahead so far* is
said where that is not so and luck alone would hardly have dealt such trainings: M is the largest absolute Welch t of
the measures, its p the share of all ways to deal the labels in which M is at least as large as it was. Several rewards
are corrected together (Bonferroni's bounds; Westfall and Young 1993). Several places get one answer first, and single
places only where that stands.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TypeVar

import numpy as np

from harness.eta.verdict.question import Question
from harness.files.plain import tells

LEVEL = 0.05
"""The chance of a false claim about the robot, in an experiment in which no reward does anything."""
LATER = 0.02
"""The level of a bound from the second look at an experiment on: the chance over all looks is then at most 6 %."""
MOST_SUBSETS_OF = 8
"""Up to so many places every set of them is tried; of more, single places count."""
ROUNDING = 1e-9
"""Statistics that differ by less, relatively, are the same: sums of floats in another order may differ so."""


@tells("p", "p_corrected=corrected", "confidence", "questions=asked", "is_decided")
@dataclass(frozen=True)
class Ruling:
    """What the tests say of one question.

    Attributes:
        p: The p-value of this question alone; None where labels were not dealt anew.
        corrected: The p-value that holds for all questions that were asked together.
        of_measures: The corrected p-value of each measure by itself, held against the largest of all of them.
        signs: 1 where the mean of a measure is better under the proposed reward, -1 where it is worse, else 0.
        beyond: Of which measures the bound leaves out 0.
        asked: How many questions were asked together, times the measures that were offered to decide each.
        looks: How often the experiment was looked at, this time included.
        grown: The seeds of a reward at looks before this one that no plan foresaw.
        offered: How many measures more could have been named to decide, where one was named after they were known.
        small: The margin that the difference is smaller than, where a plan of several looks ended the training for
            that; None where it did not.
        has_plan: Whether a plan of looks says when to ask again. Then nobody has to be told how many seeds are too few.
        missing: A clause that so many trainings that were planned or begun have no value. No test is made then.
        is_held: Whether this is one of several places, and not told because the answer over all of them is open.
    """

    p: float | None = None
    corrected: float | None = None
    of_measures: tuple[float, ...] = ()
    signs: tuple[int, ...] = ()
    beyond: tuple[bool, ...] = ()
    asked: int = 1
    looks: int = 1
    grown: tuple[int, ...] = ()
    offered: int = 0
    small: float | None = None
    has_plan: bool = False
    missing: str = ""
    is_held: bool = False

    @property
    def confidence(self) -> float:
        """How sure the bound of each measure is, so that all of them hold together in 95 % of the experiments."""
        return 1.0 - (LEVEL if self.looks == 1 else LATER) / max(1, self.asked)

    @property
    def is_decided(self) -> bool:
        """Whether a plain word is said: new trainings would differ too."""
        return any(self.beyond)

    @property
    def is_ahead(self) -> bool:
        """Whether only these trainings differ by more than luck."""
        return not self.is_decided and self.corrected is not None and self.corrected <= LEVEL and self.sign != 0

    @property
    def decider(self) -> int:
        """Which measure says most: the first whose bound leaves out 0, else that with the smallest p."""
        if self.is_decided:
            return self.beyond.index(True)
        return int(np.argmin(self.of_measures)) if self.of_measures else 0

    @property
    def sign(self) -> int:
        """1 if the measure that says most is better under the proposed reward, -1 if it is worse."""
        return self.signs[self.decider] if self.signs else 0

    def passes(self, measure: int) -> bool:
        """Whether a measure by itself says the word, plain or so far."""
        if self.is_decided:
            return self.beyond[measure]
        return self.is_ahead and self.of_measures[measure] <= LEVEL and self.signs[measure] != 0

    @property
    def is_contrary(self) -> bool:
        """Whether one measure says better and another one worse."""
        return len({self.signs[at] for at in range(len(self.signs)) if self.passes(at)}) > 1


RulingT = TypeVar("RulingT", bound=Ruling)


def dealt(questions: Sequence[Question]) -> list[Ruling]:
    """What labels dealt anew say of questions that can all be tested, by Westfall and Young's step-down procedure.

    The questions share their ways to deal labels where they have as many trainings; else by Holm's procedure. Where a
    training left no value, both have to agree: without it, and with it at the worst end.
    """
    found = _dealt(questions)
    if not any(it.has_lost for it in questions):
        return found
    worst = _dealt([it.at_worst for it in questions])
    return [
        replace(
            one,
            of_measures=tuple(
                max(p, with_it) if sign == there else 1.0
                for p, with_it, sign, there in zip(
                    one.of_measures, other.of_measures, one.signs, other.signs, strict=True
                )
            ),
        )
        for one, other in zip(found, worst, strict=True)
    ]


def _dealt(questions: Sequence[Question]) -> list[Ruling]:
    statistics = [question.statistics() for question in questions]
    sizes = [np.abs(it).max(axis=1) for it in statistics]
    ordered = [np.sort(it) for it in sizes]
    is_joint = len({question.layout.strata for question in questions}) == 1

    def alone(at: int, size: float) -> float:
        """The share of ways in which the statistic of a question is at least so large."""
        smaller = int(np.searchsorted(ordered[at], size - ROUNDING * ordered[at][-1]))
        return (len(ordered[at]) - smaller) / len(ordered[at])

    def corrected(rest: Sequence[int], p: float) -> float:
        """The chance that any of some questions has so small a p by itself."""
        if len(rest) == 1:
            return p
        if not is_joint:
            return min(1.0, len(rest) * p)
        reached = np.zeros(len(sizes[rest[0]]), np.bool_)
        for at in rest:
            larger = len(ordered[at]) - round(p * len(ordered[at]))  # sizes from here on, sorted, have this p
            if larger == 0:
                return 1.0
            # Equal sizes have the larger p of all of them: what lies as low as the one before is not so rare.
            reached |= sizes[at] > ordered[at][larger - 1] + ROUNDING * ordered[at][-1]
        return max(p, float(reached.mean()))

    of_measures = [[alone(at, abs(t)) for t in it[0]] for at, it in enumerate(statistics)]
    order = sorted(range(len(questions)), key=lambda at: min(of_measures[at]))
    so_far, found = 0.0, dict[int, Ruling]()
    for rank, at in enumerate(order):
        p, rest = min(of_measures[at]), order[rank:]
        so_far = max(so_far, corrected(rest, p))
        by_measure = tuple(max(so_far, corrected(rest, it)) for it in of_measures[at])
        signs = tuple(int(np.sign(t)) for t in statistics[at][0])
        found[at] = Ruling(p, so_far, by_measure, signs, asked=len(questions))
    return [found[at] for at in range(len(questions))]


def rule(questions: Sequence[Question], looks: int = 1, offered: Sequence[int] = ()) -> list[Ruling]:
    """What the tests say of each question; nothing of those that have too few trainings.

    Args:
        questions: Asked together, each in one place, or in several that get one answer.
        looks: How often the experiment was looked at, this time included.
        offered: Of each question, how many measures, its last ones, could have been named to decide instead of those
            before them, and were not: what was chosen after it was seen is the best of all of them. By default none.
    """
    more = [*offered, *[0] * (len(questions) - len(offered))]
    testable = [at for at, question in enumerate(questions) if question.is_testable]
    asked = sum(1 + more[at] for at in testable)
    found = [Ruling(asked=asked, looks=looks)] * len(questions)
    for at, it in zip(testable, dealt([questions[at] for at in testable]) if testable else [], strict=True):
        ruled = with_bounds(replace(it, asked=asked, looks=looks, offered=more[at]), questions[at])
        end = len(ruled.signs) - more[at]
        p, signs, beyond = ruled.of_measures[:end], ruled.signs[:end], ruled.beyond[:end]
        found[at] = replace(ruled, corrected=min(p), of_measures=p, signs=signs, beyond=beyond)
    return found


def with_bounds(ruling: RulingT, question: Question) -> RulingT:
    """The ruling with the signs of all measures, and with what their bounds say."""
    leaning = [question.leaning(at, ruling.confidence) for at in range(question.values.shape[3])]
    seen = np.sign(question.differences.mean(axis=0)).astype(int)
    signs = tuple(int(lean or sign) for lean, sign in zip(leaning, seen, strict=True))
    return replace(ruling, signs=signs, beyond=tuple(map(bool, leaning)))


def rule_places(question: Question, whole: Ruling) -> list[Ruling]:
    """What the bounds say of single places, where labels are not dealt anew.

    None of them is told where the answer over all of them is not.
    """
    places = [question.in_places(np.array([place])) for place in range(question.places)]
    shared = Ruling(
        asked=whole.asked * len(places),
        looks=whole.looks,
        offered=whole.offered,
        has_plan=whole.has_plan,
        is_held=not whole.is_decided,
    )
    deciding = len(whole.beyond)  # behind them stand those that were offered
    found = (with_bounds(shared, place) for place in places)
    return [
        replace(it, signs=it.signs[:deciding], beyond=tuple(of and not it.is_held for of in it.beyond[:deciding]))
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
    """
    if not whole.is_decided:
        return 0
    places = range(question.places)

    def is_told(there: Sequence[int], confidence: float) -> bool:
        some = question.in_places(np.array(there))
        return any(some.leaning(at, confidence) == whole.sign for at, passes in enumerate(whole.beyond) if passes)

    if len(places) > MOST_SUBSETS_OF:
        shared = 1.0 - (1.0 - whole.confidence) / len(places)
        return sum(is_told([at], shared) for at in places)
    for size in range(len(places), 0, -1):
        if not all(is_told(there, whole.confidence) for there in combinations(places, size)):
            return len(places) - size
    return len(places)
