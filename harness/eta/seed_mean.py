"""The mean of one value over seeds, and how far it can be trusted."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from harness.eta.statistics import draw_shares, interval_notes, percentile_interval


@dataclass(frozen=True)
class SeedMean:
    """A mean with its 95 % bootstrap interval over seeds.

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


def mean_over_seeds(values: Sequence[float], missing: str | None = None) -> SeedMean:
    """The mean of one value per seed.

    Args:
        values: Finite, in the order of the seeds: means whose seeds are the same are drawn the same.
        missing: Why there is not a value of every seed; becomes the last note. None if there is.
    """
    reasons = () if missing is None else (missing,)
    if not values:
        return SeedMean(None, notes=reasons)
    mean, seeds = float(np.mean(values)), len(values)
    notes = (*interval_notes(seeds), *reasons)
    if seeds == 1:
        return SeedMean(mean, seeds=1, notes=notes)
    low, high = percentile_interval(draw_shares(seeds) @ np.array(values))
    return SeedMean(mean, low, high, seeds, notes)
