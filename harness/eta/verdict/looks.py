"""A question that is asked several times, while seeds come in: a group-sequential permutation test.

Whoever looks at the results after some seeds and trains more of them if the answer is not there yet gives luck several
chances. Here each look may spend a part of the 5 %, in proportion to the seeds used (Lan and DeMets 1983). Labels are
dealt among the trainings of one look. A deal whose statistic passes the boundary of a look counts as a false claim from
then on. The boundary of a look is the smallest one that keeps to what is left.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from harness.eta.unseen import difference_bounds
from harness.eta.verdict.least_p import least_p
from harness.eta.verdict.question import Question
from harness.eta.verdict.ruling import LEVEL, ROUNDING, Ruling

ONE_PLACE = (6, 8, 12, 16, 24, 32)
SEVERAL_PLACES = (2, 3, 4, 6, 8, 12, 16)
"""Seeds of each reward in each place at each look, for four places and more."""
MANY_PLACES = 4
FUTILE_FROM, FUTILE_LOOKS, FUTILE_CONFIDENCE = 4, 5, 0.99
"""From so many seeds a place on, at the last so many looks, a small difference may end the training."""
MARGIN = 0.10
"""A difference below this counts as none: of a share in points, of another measure as a share of it."""


@dataclass(frozen=True)
class Looks:
    """When a question is asked, and what may be concluded.

    Attributes:
        seeds: Seeds of each reward in each place at each look, increasing.
        asked: How many questions the experiment asks, each with looks of its own.
        margin: A difference below this counts as none.
        level: The chance of a false claim in the whole experiment.
    """

    seeds: tuple[int, ...]
    asked: int = 1
    margin: float = MARGIN
    level: float = LEVEL

    @property
    def most(self) -> int:
        """The most seeds of each reward in each place."""
        return self.seeds[-1]

    def spent(self, look: int) -> float:
        """The chance of a false claim that may be spent up to a look, all questions together."""
        return self.level * self.seeds[look] / self.most

    def is_futile_at(self, look: int) -> bool:
        """Whether a small difference may end the training at a look."""
        return look >= len(self.seeds) - FUTILE_LOOKS and self.seeds[look] >= FUTILE_FROM


@dataclass(frozen=True)
class LookRuling(Ruling):
    """What the test says of a question that was asked several times.

    Attributes:
        look: The look that decided, or the last one there was; counted from 0.
        is_last: Whether no look is left.
    """

    has_plan: bool = True
    look: int = 0
    is_last: bool = False

    @property
    def is_over(self) -> bool:
        """Whether nothing more is to be trained for this question."""
        return self.is_decided or self.small is not None or self.is_last


def looks_for(places: int) -> tuple[int, ...]:
    """The seeds at each look in an experiment with so many places."""
    return SEVERAL_PLACES if places >= MANY_PLACES else ONE_PLACE


def rule_in_looks(question: Question, looks: Looks, complete: int) -> LookRuling:
    """What the test says at the looks that are complete; the first that decides stands.

    Args:
        question: `looks` of its seeds say at which look each was trained.
        looks: When it is asked.
        complete: How many looks are complete.
    """
    question = replace(question, is_drawn=True)
    found = LookRuling(level=looks.spent(0), asked=looks.asked)
    crossed = None
    for look in range(complete):
        there = question.until(look)
        if not there.is_testable:
            continue
        statistics = there.statistics()
        sizes = np.abs(statistics).max(axis=1)
        crossed = np.zeros(len(sizes), np.bool_) if crossed is None else crossed
        dealt = [_p(crossed, sizes, float(t)) for t in np.abs(statistics[0])]
        spent = [looks.spent(before) / looks.asked for before in range(look)]
        alone = [max(p, float(least)) for p, least in zip(dealt, least_p(there, spent), strict=True)]
        found = LookRuling(
            min(alone),
            min(1.0, min(alone) * looks.asked),
            looks.spent(look),
            tuple(min(1.0, p * looks.asked) for p in alone),
            tuple(int(np.sign(t)) for t in statistics[0]),
            looks.asked,
            looks.margin if looks.is_futile_at(look) and is_small(there, looks.margin) else None,
            is_floored=min(alone) > min(dealt),
            look=look,
            is_last=look + 1 == len(looks.seeds),
        )
        if found.is_over:
            return found
        crossed = crossed | (sizes >= _boundary(crossed, sizes, looks.spent(look) / looks.asked))
    return found


def _p(crossed: np.ndarray, sizes: np.ndarray, seen: float) -> float:
    """The share of deals that crossed at an earlier look, or reach what was seen at this one."""
    reached = sizes >= seen - ROUNDING * sizes.max()
    return float((crossed | reached).mean())


def _boundary(crossed: np.ndarray, sizes: np.ndarray, level: float) -> float:
    """The smallest statistic that leaves at most this share of deals across; infinite if none does."""
    left = math.floor(level * len(sizes) + ROUNDING) - int(crossed.sum())
    there = np.sort(sizes[~crossed])[::-1]
    if left <= 0:
        return math.inf
    if left >= len(there):
        return 0.0
    beyond = there[left]  # the largest that stays below; those that equal it stay below too
    return float(np.nextafter(beyond * (1.0 + ROUNDING), math.inf))


def is_small(question: Question, margin: float) -> bool:
    """Whether the difference of the first measure is smaller than a margin.

    With what luck may add, but for 1 % to each side, and with trainings that were not seen, but for 5 %; see
    `harness.eta.unseen`.

    Args:
        question: Its places have trainings of their own.
        margin: Above 0.
    """
    baseline, proposed = ([values[np.isfinite(values)] for values in side[..., 0].T] for side in question.values)
    low, high = difference_bounds(
        baseline, proposed, question.first_ends, seen_confidence=2.0 * FUTILE_CONFIDENCE - 1.0
    )
    return -margin < low and high < margin


def check_looks(seeds: Sequence[int]) -> str:
    """Why numbers of seeds cannot be looks; empty if they can."""
    if not seeds or any(one >= other for one, other in pairwise(seeds)):
        return "the numbers of seeds have to increase, such as 6,12,24"
    return "the first look needs at least 2 seeds" if seeds[0] < 2 else ""
