"""The mean of one value over seeds, and how far it can be trusted."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from harness.eta.interval import (
    SHARE,
    UNBOUNDED,
    Bounds,
    mean_interval,
    of_difference,
    share_variance,
    variance_of,
    why_no_interval,
)


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


def mean_over_seeds(
    values: Sequence[float], missing: str | None = None, episodes: int | None = None, bounds: Bounds = UNBOUNDED
) -> SeedMean:
    """The mean of one value per seed.

    Args:
        values: Finite.
        missing: Why there is not a value of every seed; becomes the last note. None if there is.
        episodes: Of so many episodes each value is a share, and its interval stays in [0, 1]; None if it is not one.
        bounds: What a value can be, if it is no share.
    """
    if episodes is None:
        return _mean(values, missing, variance_of, bounds)
    return _mean(values, missing, lambda known: share_variance(known, [float(np.mean(known))], episodes), SHARE)


def mean_of_known(
    values: Sequence[float | None], missing: str, episodes: int | None = None, bounds: Bounds = UNBOUNDED
) -> SeedMean:
    """The mean over those seeds that have a value; how many have none is told, with `missing` behind it."""
    known = [value for value in values if value is not None]
    told = f"{len(values) - len(known)} of {len(values)} {missing}" if len(known) < len(values) else None
    return mean_over_seeds(known, told, episodes, bounds)


def mean_lost_share(pairs: Sequence[tuple[float, float]], missing: str | None, episodes: int) -> SeedMean:
    """The mean over seeds of one share minus another one; its interval stays in [-1, 1].

    Args:
        pairs: Both shares of each seed.
        missing: As of `mean_over_seeds`.
        episodes: Of so many episodes each share is.
    """
    shares = np.mean(pairs, axis=0).tolist() if pairs else []
    lost = [one - other for one, other in pairs]
    return _mean(lost, missing, lambda known: share_variance(known, shares, episodes), of_difference(SHARE))


def _mean(
    values: Sequence[float], missing: str | None, variance: Callable[[Sequence[float]], float], bounds: Bounds
) -> SeedMean:
    reasons = () if missing is None else (missing,)
    if not values:
        return SeedMean(None, notes=reasons)
    mean, seeds = float(np.mean(values)), len(values)
    notes = (*why_no_interval(seeds), *reasons)
    if why_no_interval(seeds):
        return SeedMean(mean, seeds=seeds, notes=notes)
    low, high = mean_interval(values, variance(values), bounds=bounds)
    return SeedMean(mean, low, high, seeds, notes)
