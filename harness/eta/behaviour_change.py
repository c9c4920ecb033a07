"""The difference of a measure of behaviour under two rewards, and how far it can be trusted."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from harness.arrays import Float
from harness.eta.aggregate import interquartile_mean, probability_of_improvement
from harness.eta.interval import (
    SHARE,
    UNBOUNDED,
    Bounds,
    Interval,
    mean_interval,
    of_difference,
    share_variance,
    variance_of,
    why_no_interval,
)
from harness.eta.swaps import ALPHA, Swaps, p_of


class Measure(NamedTuple):
    """A measure of behaviour."""

    name: str
    """The name of the metric."""
    unit: str
    """The unit of its values; empty if it has none."""
    better: str
    """``higher`` or ``lower``."""
    manner: str
    """How the policies acted, or when: ``deterministic``, ``stochastic``, ``while training``, ``while learning``."""
    episodes: int | None = None
    """How many episodes it is a share of; None if it is not a share."""
    title: str = ""
    """The name for readers; if empty, they see the name with blanks."""
    bounds: Bounds = UNBOUNDED
    """What a value can be, if the measure is no share."""

    @property
    def of_difference(self) -> Bounds:
        """What the difference of two values can be."""
        return of_difference(self.bounds if self.episodes is None else SHARE)

    def to_json(self) -> dict[str, Any]:
        """Plain data; JSON has no infinite bounds, so it has none."""
        return {name: value for name, value in self._asdict().items() if name != "bounds"}


@dataclass(frozen=True)
class Change:
    """Means over seeds of one measure, which does not depend on any reward.

    Attributes:
        measure: What is measured.
        baseline: Mean over the compared seeds under the baseline; None if the metric is not defined.
        proposed: The same under the proposed reward.
        random: The same for random actions.
        seeds: How many seeds have a value under both rewards, and are compared.
        left_out: How many seeds have no value under one of the rewards.
        low: Lower end of the 95 % interval of proposed - baseline, over seeds in pairs, cut to what that can be; None
            where there is none.
        high: Upper end.
        p: The p-value for no difference, by an exact test over swapped seeds; None if it cannot be computed.
        corrected: The p-value corrected for all claims that are made together; of a measure that decides that of the
            verdict.
        values: The values of each compared seed, under the baseline and under the proposed reward.
        variance: The variance of a seed's difference; None below two seeds.
        outcomes: The mean difference with the trainings' names swapped in all ways, see `harness.eta.swaps`; None
            for a single seed, which can claim nothing.
        reason: Why the metric failed for a seed; empty if it did not fail, also if it is not defined.
        of_seeds: The compared seeds, in the order of `values`.
        level: A corrected p-value up to this says that there is a difference.
    """

    measure: Measure
    baseline: float | None
    proposed: float | None
    random: float | None
    seeds: int
    left_out: int = 0
    low: float | None = None
    high: float | None = None
    p: float | None = None
    corrected: float | None = None
    values: tuple[tuple[float, float], ...] = field(default=(), repr=False)
    variance: float | None = field(default=None, repr=False)
    outcomes: Float | None = field(default=None, repr=False, compare=False)
    reason: str = ""
    of_seeds: tuple[int, ...] = field(default=(), repr=False)
    level: float = field(default=ALPHA, repr=False)

    @property
    def name(self) -> str:
        """The name of the metric."""
        return self.measure.name

    @property
    def differences(self) -> Float:
        """Proposed - baseline of each compared seed, (seeds,)."""
        pairs = np.array(self.values, np.float64).reshape(-1, 2)
        differences: Float = pairs[:, 1] - pairs[:, 0]
        return differences

    @property
    def difference(self) -> float | None:
        """Proposed - baseline, mean over the compared seeds."""
        return float(np.mean(self.differences)) if self.values else None

    @property
    def direction(self) -> str:
        """``better`` or ``worse`` if the corrected test says so, else empty."""
        if self.corrected is None or self.corrected > self.level or not self.difference:
            return ""
        return "better" if (self.difference > 0.0) == (self.measure.better == "higher") else "worse"

    @property
    def likely(self) -> Interval | None:
        """The 90 % interval of the difference; None where there is none."""
        if self.variance is None or why_no_interval(self.seeds):
            return None
        return mean_interval(self.differences, self.variance, confidence=0.90)

    @property
    def lowest(self) -> float | None:
        """The lowest value of a seed, under either reward."""
        return min((value for pair in self.values for value in pair), default=None)

    @property
    def spread(self) -> float | None:
        """The standard deviation of one training; None below two seeds."""
        return None if self.variance is None else math.sqrt(self.variance / 2.0)

    @property
    def middles(self) -> tuple[float | None, float | None]:
        """Interquartile means over the compared seeds, for the baseline and for the proposed reward."""
        return interquartile_mean([one for one, _ in self.values]), interquartile_mean([it for _, it in self.values])

    @property
    def improvement(self) -> float | None:
        """Chance that a run of the proposed reward is better than one of the baseline."""
        one, other = [one for one, _ in self.values], [it for _, it in self.values]
        return probability_of_improvement(one, other, self.measure.better)

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            **self.measure.to_json(),
            "baseline": self.baseline,
            "proposed": self.proposed,
            "random": self.random,
            "seeds": self.seeds,
            "left_out": self.left_out,
            "difference": self.difference,
            "low": self.low,
            "high": self.high,
            "p": self.p,
            "p_corrected": self.corrected,
            "result": self.direction,
            "interquartile_means": list(self.middles),
            "probability_of_improvement": self.improvement,
            "values": [list(pair) for pair in self.values],
            "reason": self.reason,
        }


Values = Mapping[int, float | None]
"""The value of each seed; None if the metric is not defined."""


def change_of(
    measure: Measure, baseline: Values, proposed: Values, swaps: Swaps, random: Sequence[float | None] = ()
) -> Change:
    """The change of one measure.

    Args:
        measure: What is measured.
        baseline: Its values under the baseline, by seed.
        proposed: The same seeds under the proposed reward.
        swaps: The ways in which the names of a seed's trainings are swapped.
        random: Its values for random actions.
    """
    pairs = {
        seed: (one, other)
        for seed, one in baseline.items()
        if one is not None and (other := proposed[seed]) is not None
    }
    seeds, left_out = len(pairs), len(baseline) - len(pairs)
    if not pairs:
        return Change(measure, _mean(baseline.values()), _mean(proposed.values()), _mean(random), 0, left_out)
    both = np.array(list(pairs.values()))
    differences = both[:, 1] - both[:, 0]
    means = both.mean(axis=0)
    variance = _variance(differences, means.tolist(), measure.episodes)
    low, high = None, None
    if not why_no_interval(seeds):
        low, high = mean_interval(differences, variance or 0.0, bounds=measure.of_difference)
    outcomes = swaps.of(list(pairs)) @ differences / seeds if seeds > 1 else None
    return Change(
        measure,
        float(means[0]),
        float(means[1]),
        _mean(random),
        seeds,
        left_out,
        low,
        high,
        None if outcomes is None else p_of(outcomes),
        values=tuple(pairs.values()),
        variance=variance,
        outcomes=outcomes,
        of_seeds=tuple(pairs),
    )


def _variance(differences: Float, means: Sequence[float], episodes: int | None) -> float | None:
    if len(differences) < 2:
        return None
    return variance_of(differences) if episodes is None else share_variance(differences, means, episodes)


def _mean(values: Any) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None
