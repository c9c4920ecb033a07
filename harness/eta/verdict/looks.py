"""A question that is asked several times, while seeds come in.

Whoever looks at the results after some seeds and trains more of them if the answer is not there yet gives luck several
chances. The bound that a plain word rests on allows for a training that was not seen, so it moves little from look to
look: from the second look on its level is `LATER`, and the chance of a false word over all looks stays at 6 % at most
(docs/statistics.md). Labels are dealt anew once, at the last look.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from harness.arrays import Ints
from harness.eta.verdict.question import Question
from harness.eta.verdict.ruling import LATER, LEVEL, Ruling, dealt, with_bounds

ONE_PLACE = (6, 8, 12, 16, 24, 32)
SEVERAL_PLACES = (2, 3, 4, 6, 8, 12, 16)
"""Seeds of each reward in each place at each look, for four places and more."""
MANY_PLACES = 4
FUTILE_FROM, FUTILE_LOOKS = 4, 5
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
    """

    seeds: tuple[int, ...]
    asked: int = 1
    margin: float = MARGIN

    def is_futile_at(self, look: int) -> bool:
        """Whether a small difference may end the training at a look."""
        return look >= len(self.seeds) - FUTILE_LOOKS and self.seeds[look] >= FUTILE_FROM


@dataclass(frozen=True)
class LookRuling(Ruling):
    """What the tests say of a question that was asked several times.

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


def rule_in_looks(question: Question, trained_at: Ints, looks: Looks, complete: int) -> LookRuling:
    """What the tests say at the looks that are complete; the first that decides stands.

    Args:
        question: About all trainings there are.
        trained_at: The look at which a row was trained in each place, (rows, places).
        looks: When it is asked.
        complete: How many looks are complete.
    """
    found = LookRuling(asked=looks.asked)
    for look in range(complete):
        there, is_last = question.among(trained_at <= look), look + 1 == len(looks.seeds)
        if not there.is_testable:
            found = replace(found, is_last=is_last)
            continue
        ruled = with_bounds(LookRuling(asked=looks.asked, looks=look + 1, look=look), there)
        small = looks.margin if looks.is_futile_at(look) and is_small(there, looks.margin) else None
        found = replace(ruled, small=small, is_last=is_last)
        if found.is_last and not found.is_decided:
            (by_deals,) = dealt([there])
            corrected = tuple(min(1.0, p * looks.asked) for p in by_deals.of_measures)
            found = replace(found, p=by_deals.p, corrected=min(corrected), of_measures=corrected)
        if found.is_over:
            return found
    return found


def is_small(question: Question, margin: float) -> bool:
    """Whether the difference of the first measure is smaller than a margin, at the level of later looks."""
    low, high = question.bounds(0, 1.0 - LATER)
    return question.has_ends(0) and -margin < low and high < margin


STEPS = 400
"""Points of the normal density below, to either side of 0."""


def luck_in(seeds: Sequence[int]) -> float:
    """The chance that rewards that do not differ are told apart at one of several looks that each test at 5 %.

    The statistics of looks are a random walk in the number of seeds (Armitage, McPherson and Rowe 1969).

    Args:
        seeds: Of each reward at each look, increasing.
    """
    from scipy.special import ndtri  # here, since importing scipy takes time that most commands need not spend

    edge = float(ndtri(1.0 - LEVEL / 2.0))
    at, density, before = np.zeros(1), np.ones(1), 0
    for count in seeds:
        step, reach = math.sqrt(count - before), edge * math.sqrt(count)
        to = np.linspace(-reach, reach, 2 * STEPS + 1)
        moves = np.exp(-0.5 * ((to[:, None] - at[None, :]) / step) ** 2) / (step * math.sqrt(2.0 * math.pi))
        at, density, before = to, (moves @ density) * (to[1] - to[0]), count
    return 1.0 - float(density.sum())


def check_looks(seeds: Sequence[int]) -> str:
    """Why numbers of seeds cannot be looks; empty if they can."""
    if not seeds or any(one >= other for one, other in pairwise(seeds)):
        return "the numbers of seeds have to increase, such as 6,12,24"
    return "the first look needs at least 2 seeds" if seeds[0] < 2 else ""
