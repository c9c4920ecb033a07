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


def mean_interval(
    values: Sequence[float] | Float, variance: float, confidence: float = CONFIDENCE, bounds: Bounds = UNBOUNDED
) -> Interval:
    """Student's interval for the mean that values, one per seed, are drawn around.

    It is cut to what the mean can be. That costs no coverage: what is cut away could not hold the mean.

    Args:
        values: At least `LEAST_SEEDS`, independent of one another.
        variance: Of a single value, see `variance_of` and `share_variance`.
        confidence: How often the interval holds the mean.
        bounds: What a value can be. Where a value lies outside, they are wrong, and nothing is cut.
    """
    reach = quantile(confidence, len(values) - 1) * math.sqrt(variance / len(values))
    middle = float(np.mean(values))
    if not are_within(values, bounds):
        return middle - reach, middle + reach
    least, greatest = min(bounds[0], middle), max(bounds[1], middle)  # which rounding may have passed
    return max(middle - reach, least), min(middle + reach, greatest)


def welch_freedom(variances: Sequence[float], counts: Sequence[int]) -> float:
    """Degrees of freedom of a difference of the means of groups that are not paired (Satterthwaite 1946, Welch 1947).

    Args:
        variances: Of a single value, by group.
        counts: How many values each group has, at least two.
    """
    parts = [variance / count for variance, count in zip(variances, counts, strict=True)]
    squares = sum(part**2 / (count - 1) for part, count in zip(parts, counts, strict=True))
    return sum(parts) ** 2 / squares if squares > 0.0 else float(sum(counts) - len(counts))


def difference_interval(
    baseline: Sequence[float] | Float,
    proposed: Sequence[float] | Float,
    variances: tuple[float, float],
    confidence: float = CONFIDENCE,
    bounds: Bounds = UNBOUNDED,
) -> Interval:
    """Welch's interval for the difference of the means, proposed - baseline, of two groups that are not paired.

    It is cut to what the difference can be, as that of `mean_interval`.

    Args:
        baseline: One value per training, at least two, independent of one another.
        proposed: The same; there may be more or fewer of them.
        variances: Of a single value under the baseline and under the proposed reward, each from its own group: see
            `variance_of` and, for a share, `share_variance`.
        confidence: How often the interval holds the difference.
        bounds: What a single value can be. Where one lies outside, they are wrong, and nothing is cut.
    """
    counts = len(baseline), len(proposed)
    error = math.sqrt(sum(variance / count for variance, count in zip(variances, counts, strict=True)))
    reach = quantile(confidence, welch_freedom(variances, counts)) * error
    middle = float(np.mean(proposed)) - float(np.mean(baseline))
    if not (are_within(baseline, bounds) and are_within(proposed, bounds)):
        return middle - reach, middle + reach
    low, high = of_difference(bounds)
    return max(middle - reach, min(low, middle)), min(middle + reach, max(high, middle))


def are_within(values: Sequence[float] | Float, bounds: Bounds) -> bool:
    """Whether no value lies outside of the bounds, by more than rounding."""
    return bounds[0] - ROUNDING <= float(np.min(values)) and float(np.max(values)) <= bounds[1] + ROUNDING


def variance_of(values: Sequence[float] | Float) -> float:
    """The variance of a single value, from at least two values."""
    return float(np.var(values, ddof=1))


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


def share_variance(values: Sequence[float] | Float, shares: Sequence[float], episodes: int) -> float:
    """The variance of a single value, if values are shares of episodes or differences of shares.

    Seeds that all succeed do not tell how often one fails: their own variance is 0 and an interval by it is a point.
    Two things stand for what they do not show. A share of so many episodes varies by itself, after Agresti and Coull
    (1998) with four more episodes, half of them successful. And one seed that was not seen lies `UNSEEN` away; it
    loses its weight as seeds come in.

    Args:
        values: One per seed, at least two.
        shares: The mean shares that a value is made of: one, or both that it is the difference of.
        episodes: The number of episodes that each share is of.
    """
    count = len(values)
    floor = sum(binomial_variance(share, episodes) for share in shares)
    seen = max(variance_of(values), floor)
    return max(seen, ((count - 1) * seen + UNSEEN**2) / count)  # it makes no interval narrower


UNSEEN = 0.25
"""By simulation: with less, the interval misses where most seeds never fail and a rare one does."""


def binomial_variance(share: float, episodes: int) -> float:
    """The variance of a share of so many episodes, after Agresti and Coull."""
    shrunk = (min(1.0, max(0.0, share)) * episodes + 2.0) / (episodes + 4.0)
    return shrunk * (1.0 - shrunk) / (episodes + 4.0)


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
