"""The least p of trainings that all succeed or fail, beside trainings that do neither: luck that no spread shows.

Where one reward succeeds in four of five trainings and fails in the fifth, ten trainings all succeed in one of ten
experiments. Beside a steady reward of the same mean they stand apart, each label in its place, and the test of dealt
labels gives its smallest p: it takes for granted that the names could be swapped. How often so few failures, or so
many, come about is a binomial chance, whatever the other reward's spread is (Clopper and Pearson 1934).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from harness.arrays import Float, Mask
from harness.eta.verdict.question import BOTH, Question

NEAR = 0.05
"""A training within this share of the way from one end of the first measure to the other lies at that end."""
FEW = 0.2
"""Up to this share of its trainings may a reward have at an end, and still count as one that does not reach it."""


class _Side(NamedTuple):
    """The trainings of one reward, where each of them lies at an end of the first measure."""

    side: int
    is_high: Mask
    """(rows, places): at the better end."""
    is_low: Mask
    """At the other one."""


def least_p(question: Question, spent: Sequence[float] = ()) -> Float:
    """What the p-value of each measure is at least, (measures,); 0 where nothing asks for more.

    All trainings of one reward have to lie at the ends of the first measure, and few of the other one (`FEW`) at an
    end at which they lie. Then let q be the share of trainings at the worse end with which the means of both rewards
    would be equal. The p-value is at least twice the chance that so few, or so many, lie there as were seen. Where no
    training lies at an end, `Question.ends` says what a training there would have had. A measure of which that is not
    known has the least p of the first one.

    Args:
        question: The question, as it stands at the last look.
        spent: The chance of a false answer that was spent up to each earlier look. Luck had a chance at each of them.
    """
    least: Float = np.zeros(question.values.shape[3])
    if not question.is_testable:
        return least
    for side in _at_ends(question):
        of_first = _least_of(question, side, 0, 0.0, spent)
        found = [_least_of(question, side, measure, of_first, spent) for measure in range(len(least))]
        least = np.maximum(least, found)
    return least


def _at_ends(question: Question) -> list[_Side]:
    """The sides whose trainings all lie at ends where few of the other side's do."""
    low, high = np.moveaxis(question.ends[:, 0], -1, 0)
    if not np.isfinite(high - low).all():
        return []
    known, values, near = question.known[..., 0], question.values[..., 0], NEAR * (high - low)
    at_ends = np.stack([known & (values >= high - near), known & (values <= low + near)])
    counts, trainings = at_ends.sum(axis=(2, 3)), known.sum(axis=(1, 2))
    is_reached, is_frequent = counts > 0, counts > FEW * trainings
    return [
        _Side(side, *at_ends[:, side])
        for side in BOTH
        if counts[:, side].sum() == trainings[side] and not (is_reached[:, side] & is_frequent[:, 1 - side]).any()
    ]


def _least_of(question: Question, side: _Side, measure: int, unknown: float, spent: Sequence[float]) -> float:
    """The least p of one measure; 0 where no share of failures would make the means equal.

    Args:
        question: The question.
        side: The reward whose trainings all lie at the ends.
        measure: Which.
        unknown: The answer where an end is not known.
        spent: See `least_p`.
    """
    ends, values = question.ends[:, measure], question.values[..., measure]
    high = _mean_at(values[side.side], side.is_high, ends[:, 1])
    low = _mean_at(values[side.side], side.is_low, ends[:, 0])
    if not np.isfinite(high - low):
        return unknown
    other = float(np.nanmean(values[1 - side.side], axis=0).mean())
    if not (low < high and low <= other <= high):
        return 0.0
    share, failed = (high - other) / (high - low), int(side.is_low.sum())
    known = side.is_low | side.is_high
    before = [int((known & (question.looks <= look)).sum()) for look in range(len(spent))]
    chance = crossed_before(before, spent, share) + float(both_sides(int(known.sum()), share)[failed])
    return min(1.0, chance)


def both_sides(trainings: int, share: float) -> Float:
    """Twice the chance of so few failures, or so many, of some trainings of which a share fails: by their number."""
    from scipy.special import bdtr  # here, since importing scipy takes time that most commands need not spend

    failed = np.arange(trainings + 1)
    few, many = bdtr(failed, trainings, share), bdtr(trainings - failed, trainings, 1.0 - share)
    chances: Float = 2.0 * np.minimum(few, many)
    return chances


def crossed_before(trainings: Sequence[int], spent: Sequence[float], share: float) -> float:
    """The chance that failures were so few, or so many, at an earlier look that they gave an answer there.

    Args:
        trainings: How many there were at each look.
        spent: See `least_p`.
        share: The share of trainings that fail.
    """
    from scipy.special import bdtr  # as above

    crossed, seen, alive = 0.0, 0, np.ones(1)
    for count, level in zip(trainings, spent, strict=True):
        more = np.arange(count - seen + 1)
        alive = np.convolve(alive, np.diff(bdtr(more, count - seen, share), prepend=0.0))
        is_rare = crossed + both_sides(count, share) <= level
        crossed, alive, seen = crossed + float(alive[is_rare].sum()), np.where(is_rare, 0.0, alive), count
    return crossed


def _mean_at(values: Float, there: Mask, ends: Float) -> float:
    """The mean over places of the trainings at an end; of a place that has none, what a training there would have."""
    counts = (there & np.isfinite(values)).sum(axis=0)
    sums = np.where(there, np.nan_to_num(values), 0.0).sum(axis=0)
    return float(np.where(counts > 0, sums / np.maximum(counts, 1), ends).mean())
