"""The mean of one value over seeds, and how far it can be trusted."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from harness.eta.statistics import FEW_SEEDS, draw_shares, percentile_interval

ONE_SEED = "one seed: no interval"


@dataclass(frozen=True)
class SeedMean:
    """A mean with its 95 % bootstrap interval over seeds.

    Attributes:
        mean: None where there is no value.
        low: Lower end; None where there is no interval.
        high: Upper end.
        seeds: How many seeds it rests on.
        note: Why something is missing, or what to keep in mind; empty if nothing.
    """

    mean: float | None
    low: float | None = None
    high: float | None = None
    seeds: int = 0
    note: str = ""

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)


def mean_over_seeds(values: Sequence[float], missing: str = "") -> SeedMean:
    """The mean of one value per seed.

    Args:
        values: Finite, in the order of the seeds: means whose seeds are the same are drawn the same.
        missing: Why there is not a value of every seed; becomes part of the note.
    """
    if not values:
        return SeedMean(None, note=missing)
    mean = float(np.mean(values))
    if len(values) == 1:
        return SeedMean(mean, seeds=1, note=_join(ONE_SEED, missing))
    low, high = percentile_interval(draw_shares(len(values)) @ np.array(values))
    rough = f"{len(values)} seeds: the interval is rough below {FEW_SEEDS}" if len(values) < FEW_SEEDS else ""
    return SeedMean(mean, low, high, len(values), _join(rough, missing))


def _join(*parts: str) -> str:
    return "; ".join(part for part in parts if part)
