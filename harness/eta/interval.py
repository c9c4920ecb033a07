"""Intervals over seeds that cover as often as they claim: Student's t, and a jackknife for numbers that are no means.

``docs/statistics.md`` shows by simulation how often they hold the truth, and why resampling was not taken.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from harness.arrays import Float

CONFIDENCE = 0.95
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
    return bounds[0] - ROUNDING <= float(np.min(values)) and float(np.max(values)) <= bounds[1] + ROUNDING


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
