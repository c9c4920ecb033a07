"""The mean of one value over seeds, and how far it can be trusted."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from harness.eta.interval import CONFIDENCE, UNBOUNDED, Bounds, cut_to, mean_bounds, why_no_interval


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


def mean_over_seeds(values: Sequence[float], missing: str | None = None, bounds: Bounds = UNBOUNDED) -> SeedMean:
    """The mean of one value per seed.

    Args:
        values: Finite.
        missing: Why there is not a value of every seed; becomes the last note. None if there is.
        bounds: What a value can be; the interval allows for one more at either end, see `harness.eta.interval`.
    """
    reasons = () if missing is None else (missing,)
    if not values:
        return SeedMean(None, notes=reasons)
    mean, seeds = float(np.mean(values)), len(values)
    if too_few := why_no_interval(seeds):
        return SeedMean(mean, seeds=seeds, notes=(*too_few, *reasons))
    low, high = cut_to(mean_bounds([np.asarray(values, np.float64)], [bounds], CONFIDENCE), bounds)
    return SeedMean(mean, low, high, seeds, reasons)


def mean_of_known(values: Sequence[float | None], missing: str, bounds: Bounds = UNBOUNDED) -> SeedMean:
    """The mean over those seeds that have a value; how many have none is told, with `missing` behind it."""
    known = [value for value in values if value is not None]
    told = f"{len(values) - len(known)} of {len(values)} {missing}" if len(known) < len(values) else None
    return mean_over_seeds(known, told, bounds)
