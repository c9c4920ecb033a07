"""Intervals over seeds that cover as often as they claim: bounds of means, and a jackknife for what is no mean.

Ten trainings that all end at 1.00 have no spread, and yet one in five may fail. A sentence that says that something is
small, or surely larger, has to allow for that. So there is one training more than were seen. It lies where it speaks
most against the sentence: in the reward and the place where it weighs most, at the end of what the measure can be.
Student's bound is taken over all of them. A training that was begun and left no value lies there too.

With shares of 0 and 1 this is close to Clopper and Pearson's bound (1934), which is exact: of 10 trainings none fails,
then at most .26 of all do (exactly: .26); one of 10: .40 (.39); none of 20: .13 (.14); none of 32: .08 (.09).

``docs/statistics.md`` shows by simulation how often they hold the truth, and why resampling was not taken.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from harness.arrays import Float

CONFIDENCE = 0.95
ONE_SIDED = 2.0 * CONFIDENCE - 1.0
"""The confidence of a pair of bounds, each of which fails in 5 %: 90 %."""
LEAST_SEEDS = 3
"""The fewest seeds with an interval. That of two seeds would be 18 times as wide as that of many, and say nothing."""

Interval: TypeAlias = tuple[float, float]
Bounds: TypeAlias = tuple[float, float]
"""The least and the greatest value that something can have; infinite where nothing is known."""
UNBOUNDED: Bounds = (-math.inf, math.inf)
SHARE: Bounds = (0.0, 1.0)
"""The bounds of a share of episodes, and of a mean over them of something between 0 and 1."""
ROUNDING = 1e-9
"""By so much a mean may pass its bounds: the way along a straight line may be computed as shorter than the line."""


def are_bounds(given: object) -> bool:
    """Whether something that strangers give are bounds: two numbers, the lower one first."""
    is_pair = isinstance(given, tuple | list) and len(given) == 2 and all(isinstance(end, int | float) for end in given)
    return is_pair and given[0] < given[1]  # type: ignore[index] # a pair


def of_difference(bounds: Bounds) -> Bounds:
    """The bounds of the difference of two values that have these bounds each."""
    low, high = bounds
    return low - high, high - low


def why_no_interval(seeds: int) -> tuple[str, ...]:
    """The reason why so few seeds have no interval, as notes; empty if they have one."""
    if seeds >= LEAST_SEEDS:
        return ()
    told = "one seed" if seeds == 1 else f"{seeds} seeds"
    return (f"{told}: no interval below {LEAST_SEEDS} seeds",)


def quantile(confidence: float, freedom: float) -> float:
    """How many standard errors Student's interval reaches to both sides."""
    from scipy.special import stdtrit  # here, since importing scipy takes time that most commands need not spend

    return float(stdtrit(freedom, 0.5 + confidence / 2.0))


def cut_to(interval: Interval, can_be: Bounds) -> Interval:
    """An interval cut to what a number can be: what is cut away could not hold it."""
    (low, high), (least, most) = interval, can_be
    middle = (low + high) / 2.0
    return max(low, min(least, middle)), min(high, max(most, middle))


def are_within(values: Sequence[float] | Float, bounds: Bounds) -> bool:
    """Whether no value lies outside of the bounds, by more than rounding."""
    return bool(np.all(np.clip(values, bounds[0] - ROUNDING, bounds[1] + ROUNDING) == values))


def spread_range(spread: float, seeds: int) -> Interval:
    """The smallest and the largest spread that values with this one are likely drawn from, an 80 % interval.

    Args:
        spread: Standard deviation of the values.
        seeds: How many values there are, at least two.
    """
    from scipy.special import chdtri

    freedom = seeds - 1
    smallest, largest = (spread * math.sqrt(freedom / float(chdtri(freedom, tail))) for tail in (0.1, 0.9))
    return smallest, largest


NO_TRAININGS = np.zeros((3, 1))
_LESS = np.array([[-1.0], [1.0], [1.0]])
"""A mean is taken away; variances add up."""
NONE_LOST = (0,)
"""No training was begun that left no value."""


@dataclass(frozen=True, eq=False)
class Side:
    """What a measure came to in the trainings by one reward.

    Attributes:
        values: The values of its trainings, by place; at least two in each.
        ends: What a value can be, by place. Nothing is added at an end that is infinite.
        lost: How many trainings were begun in each place and left no value; one number for all.
    """

    values: Sequence[Float]
    ends: Sequence[Bounds]
    lost: Sequence[int] = NONE_LOST

    @cached_property
    def lowest(self) -> Float:
        """The mean where what was not seen is at the lower end; see `_means`."""
        return _means(self.values, [low for low, _ in self.ends], self.lost)

    @cached_property
    def highest(self) -> Float:
        """The mean where what was not seen is at the upper end; see `_means`."""
        return _means(self.values, [high for _, high in self.ends], self.lost)


def difference_bounds(baseline: Side, proposed: Side, confidence: float = ONE_SIDED) -> Interval:
    """The least and the most that proposed - baseline can be, means over places; each is a bound by itself.

    Trainings are not paired, and there may be more of one. One training was not seen, of one reward in one place,
    wherever that is worst: trainings fail one by one, so that n perfect ones in each of m places say as much as m n in
    a single one.

    Args:
        baseline: The trainings by the baseline.
        proposed: Those by the other reward.
        confidence: That both bounds hold; either one fails in half of the rest.
    """
    least = _most(baseline.highest, proposed.lowest, confidence)
    return -least, _most(proposed.highest, baseline.lowest, confidence)


def mean_bounds(side: Side, confidence: float = ONE_SIDED) -> Interval:
    """The least and the most that the mean over places of one reward can be; see `difference_bounds`."""
    return -_most(NO_TRAININGS, side.lowest, confidence), _most(side.highest, NO_TRAININGS, confidence)


def _means(values: Sequence[Float], ends: Sequence[float], lost: Sequence[int]) -> Float:
    """The mean over places of one reward: as it was seen, then with the training not seen in one place after another.

    (3, 1 + places), or (3, 1) where no end is known: the mean, its variance, and the sum over places of variance^2 /
    degrees of freedom, as Satterthwaite needs it.
    """
    if any(lost):
        counts = np.broadcast_to(lost, len(values))
        values = [np.append(there, [end] * count) for there, end, count in zip(values, ends, counts, strict=True)]
    seen = list(map(_moments, values))
    unseen = (
        [*seen[:place], _moments(np.append(values[place], end)), *seen[place + 1 :]]
        for place, end in enumerate(ends)
        if math.isfinite(end)
    )
    rows = np.array([seen, *unseen])
    variances = rows[..., 1] / len(values) ** 2
    sums: Float = np.add.reduce([rows[..., 0], variances, variances * variances / rows[..., 2]], axis=2)
    sums[0] /= len(values)
    return sums


def _moments(values: Float) -> tuple[float, float, int]:
    """The mean, its variance and the degrees of freedom."""
    count = len(values)
    mean = np.add.reduce(values) / count  # as `mean` and `var` do, which take six times as long for so few
    away = values - mean
    return mean, np.add.reduce(away * away) / (count - 1) / count, count - 1


def _most(one: Float, other: Float, confidence: float) -> float:
    """The most that one mean less another one can be, wherever the training is that was not seen."""
    from scipy.special import stdtrit  # here, as in `quantile`

    less = other * _LESS
    mean, variance, squares = np.concatenate([one + less[:, :1], one[:, :1] + less[:, 1:]], axis=1)
    freedom = np.divide(variance * variance, squares, out=np.ones_like(squares), where=squares > 0.0)
    return float((mean + stdtrit(freedom, 0.5 + confidence / 2.0) * np.sqrt(variance)).max())


@dataclass(frozen=True, eq=False)
class Jackknife:
    """A number, and its values without each of the seeds that it rests on.

    Attributes:
        value: The number from all seeds.
        left_out: Without one seed at a time, (seeds,); a group of seeds each where two groups are not paired.
    """

    value: float
    left_out: tuple[Float, ...]

    @property
    def is_defined(self) -> bool:
        """Whether it stays defined if any one of the seeds is left out."""
        return bool(np.isfinite(self.value)) and all(np.isfinite(group).all() for group in self.left_out)

    def interval(self, confidence: float = CONFIDENCE) -> Interval:
        """Delete-one-seed jackknife with Student's t; Welch's degrees of freedom where groups are not paired."""
        variances = [(len(group) - 1) * float(group.var()) for group in self.left_out]
        total = sum(variances)
        if total == 0.0:
            return self.value, self.value
        parts = zip(variances, self.left_out, strict=True)
        freedom = 1.0 / sum((variance / total) ** 2 / (len(group) - 1) for variance, group in parts)
        reach = quantile(confidence, freedom) * float(np.sqrt(total))
        return self.value - reach, self.value + reach


Sums: TypeAlias = Mapping[Any, Float]
"""An index of each scored group, by whose reward scored whose runs; several values of each side by side."""


def jackknife(number: Callable[[Sums], Float], whole: Sums, left_out: Sequence[Sums]) -> Jackknife:
    """The jackknife of any number made of indices.

    Args:
        number: From indices, each (count,), to the number, (count,); not finite where it is not defined.
        whole: The indices of all seeds, each (1,).
        left_out: The indices without one seed at a time, each (seeds,); one entry per group of seeds.
    """
    with np.errstate(all="ignore"):  # a number that is not defined says so
        return Jackknife(float(number(whole)[0]), tuple(number(sums) for sums in left_out))
