"""The mean of one value over seeds, and how far it can be trusted."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from harness.eta.interval import mean_interval, share_variance, variance_of, why_no_interval


@dataclass(frozen=True)
class SeedMean:
    """A mean, or a difference of means, with its 95 % interval over seeds.

    Attributes:
        mean: None where there is no value.
        low: Lower end; None where there is no interval.
        high: Upper end.
        seeds: How many seeds it rests on.
        notes: Why something is missing, or what to keep in mind.
    """

    mean: float | None
    low: float | None = None
    high: float | None = None
    seeds: int = 0
    notes: tuple[str, ...] = ()

    @property
    def note(self) -> str:
        """All notes as one text; may be empty."""
        return "; ".join(self.notes)

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        data = {"mean": self.mean, "low": self.low, "high": self.high, "seeds": self.seeds}
        return {**data, "note": self.note}


def mean_over_seeds(values: Sequence[float], missing: str | None = None, episodes: int | None = None) -> SeedMean:
    """The mean of one value per seed.

    Args:
        values: Finite.
        missing: Why there is not a value of every seed; becomes the last note. None if there is.
        episodes: Of so many episodes each value is a share, and its interval stays in [0, 1]; None if it is not one.
    """
    reasons = () if missing is None else (missing,)
    if not values:
        return SeedMean(None, notes=reasons)
    mean, seeds = float(np.mean(values)), len(values)
    notes = (*why_no_interval(seeds), *reasons)
    if why_no_interval(seeds):
        return SeedMean(mean, seeds=seeds, notes=notes)
    variance = variance_of(values) if episodes is None else share_variance(values, [mean], episodes)
    low, high = mean_interval(values, variance)
    if episodes is not None:  # no share is below 0 or above 1, and an interval that says so holds the truth no less
        low, high = max(low, 0.0), min(high, 1.0)
    return SeedMean(mean, low, high, seeds, notes)
