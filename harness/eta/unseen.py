"""What a mean can be at most and at least, if one more training may end quite otherwise than all that were seen.

Ten trainings that all end at 1.00 have no spread, and yet one in five may fail. A sentence that says that something is
small, or surely larger, has to allow for that. So there is one training more than were seen. It lies where it speaks
most against the sentence: in the reward and the place where it weighs most, at the end of what the measure can be.
Student's bound is taken over all of them. A training that was begun and left no value lies there too.

With shares of 0 and 1 this is close to Clopper and Pearson's bound (1934), which is exact: of 10 trainings none fails,
then at most .26 of all do (exactly: .26); one of 10: .40 (.39); none of 20: .13 (.14); none of 32: .08 (.09).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from harness.arrays import Float
from harness.eta.interval import CONFIDENCE, Bounds, Interval

ONE_SIDED = 2.0 * CONFIDENCE - 1.0
"""The confidence of a pair of bounds, each of which fails in 5 %: 90 %."""


class _Means(NamedTuple):
    """The mean over places of one reward: as it was seen, then with the training not seen in one place after the other.

    Each is (1 + places,), or (1,) where no end is known.
    """

    means: Float
    variances: Float
    """The variance of the mean."""
    squares: Float
    """The sum over places of variance^2 / degrees of freedom, as Satterthwaite needs it."""


NO_TRAININGS = _Means(np.zeros(1), np.zeros(1), np.zeros(1))
NONE_LOST = (0,)
"""No training was begun that left no value."""


def difference_bounds(
    baseline: Sequence[Float],
    proposed: Sequence[Float],
    ends: Sequence[Bounds],
    confidence: float = ONE_SIDED,
    lost: tuple[Sequence[int], Sequence[int]] = (NONE_LOST, NONE_LOST),
) -> Interval:
    """The least and the most that proposed - baseline can be, means over places; each is a bound by itself.

    Trainings are not paired. One training was not seen, of one reward in one place, wherever that is worst: trainings
    fail one by one, so that n perfect ones in each of m places say as much as m n in a single one.

    Args:
        baseline: The values of its trainings, by place; at least two in each.
        proposed: The same; there may be more or fewer of them.
        ends: What a value can be, by place. Nothing is added at an end that is infinite.
        confidence: That both bounds hold; either one fails in half of the rest.
        lost: How many trainings of either reward were begun in each place and left no value; one number for all.
    """
    low_ends, high_ends = zip(*ends, strict=True)
    ours, theirs = lost
    least = _most(_means(baseline, high_ends, ours), _means(proposed, low_ends, theirs), confidence)
    return -least, _most(_means(proposed, high_ends, theirs), _means(baseline, low_ends, ours), confidence)


def mean_bounds(
    values: Sequence[Float], ends: Sequence[Bounds], confidence: float = ONE_SIDED, lost: Sequence[int] = NONE_LOST
) -> Interval:
    """The least and the most that the mean over places of one reward can be; see `difference_bounds`."""
    low_ends, high_ends = zip(*ends, strict=True)
    least = _most(NO_TRAININGS, _means(values, low_ends, lost), confidence)
    return -least, _most(_means(values, high_ends, lost), NO_TRAININGS, confidence)


def _means(values: Sequence[Float], ends: Sequence[float], lost: Sequence[int] = NONE_LOST) -> _Means:
    """See `_Means`."""
    counts = np.broadcast_to(lost, len(values))
    begun = [np.append(there, np.full(count, end)) for there, end, count in zip(values, ends, counts, strict=True)]
    seen = np.array([_moments(there) for there in begun])
    rows = [seen]
    for place, (there, end) in enumerate(zip(begun, ends, strict=True)):
        if np.isfinite(end):
            rows.append(seen.copy())
            rows[-1][place] = _moments(np.append(there, end))
    means, variances, freedoms = np.moveaxis(np.array(rows), 2, 0)
    variances = variances / len(values) ** 2
    return _Means(means.mean(axis=1), variances.sum(axis=1), (variances**2 / freedoms).sum(axis=1))


def _moments(values: Float) -> tuple[float, float, int]:
    """The mean, its variance and the degrees of freedom."""
    return float(values.mean()), float(values.var(ddof=1)) / len(values), len(values) - 1


def _most(one: _Means, other: _Means, confidence: float) -> float:
    """The most that one mean less another one can be, wherever the training is that was not seen."""
    from scipy.special import stdtrit  # here, as in `harness.eta.interval`

    either = (_joined(a, b) for a, b in zip(one, other, strict=True))
    (ones, others), (own, their), (own_squares, their_squares) = either
    variance, squares = own + their, own_squares + their_squares
    freedom = np.divide(variance**2, squares, out=np.ones_like(squares), where=squares > 0.0)
    return float((ones - others + stdtrit(freedom, 0.5 + confidence / 2.0) * np.sqrt(variance)).max())


def _joined(one: Float, other: Float) -> tuple[Float, Float]:
    """Both as seen, then either one with its training not seen beside the other one as seen."""
    return np.append(one, np.full(len(other) - 1, one[0])), np.append(np.full(len(one), other[0]), other[1:])
