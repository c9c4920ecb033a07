"""The note's indices of a group of runs, I_N and I_P, and their ratios, eta_N and eta_P.

As they were computed for the published table (NOTE eq. 38-44 with r_1 the accumulated reward).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from harness.eta.interval import CONFIDENCE, UNBOUNDED, Bounds, Side, cut_to, mean_bounds, why_no_interval
from harness.files.plain import Plain, tells

DECIMALS = 1
"""I_N and I_P are shown rounded to 0.1, as published; ratios are taken before rounding."""
NOTHING, NEAR_ZERO = "n/a", "near zero"
"""What is shown of a ratio without a value, and of one that says little."""


@tells("first_negative", "crossover", "steps", "I_N", "I_P", "total")
@dataclass(frozen=True)
class Index(Plain):
    """The index of a group of runs, read from its mean curve.

    Attributes:
        first_negative: First step at which the curve is negative, counted from 0; None if it is never negative.
        crossover: First step after `first_negative` at which the curve is not negative; None if there is none.
        steps: Length of the curve.
        negative_sum: What I_N is before rounding.
        positive_sum: What I_P is before rounding.
    """

    first_negative: int | None
    crossover: int | None
    steps: int
    negative_sum: float
    positive_sum: float

    @property
    def I_N(self) -> float:  # noqa: N802 (the note's name)
        """Sum of the curve's negative values, rounded to 0.1, NOTE eq. 41."""
        return round(self.negative_sum, DECIMALS) + 0.0  # no -0.0

    @property
    def I_P(self) -> float:  # noqa: N802
        """Sum of the curve's positive values, rounded to 0.1, NOTE eq. 42."""
        return round(self.positive_sum, DECIMALS) + 0.0

    @property
    def total(self) -> float:
        """I_N + I_P, NOTE eq. 38: the sum of the whole mean curve, rounded to 0.1."""
        return round(self.negative_sum + self.positive_sum, DECIMALS) + 0.0


@tells("value", "low", "high", "seeds", "note")
@dataclass(frozen=True)
class Estimate(Plain):
    """A number with its 95 % interval, or the reason why there is none: a mean, a difference, a ratio, Kendall's tau.

    Attributes:
        value: None where it is not defined.
        low: Lower end of the interval; None where there is none.
        high: Upper end.
        seeds: How many seeds it rests on, or how many of whatever the interval is over; 0 without a value.
        notes: Why something is missing, or what to keep in mind.
        near_zero: Of a ratio: which of its indices is near zero, and beside what. It then says little. Else None.
    """

    value: float | None
    low: float | None = None
    high: float | None = None
    seeds: int = 0
    notes: tuple[str, ...] = ()
    near_zero: str | None = None

    @property
    def remarks(self) -> tuple[str, ...]:
        """All remarks on the number. That an index is near zero comes first."""
        weak = () if self.near_zero is None else (f"{self.near_zero}: the ratio says little",)
        return (*weak, *self.notes)

    @property
    def is_telling(self) -> bool:
        """Whether there is a value that says something."""
        return self.value is not None and self.near_zero is None

    @property
    def why(self) -> str:
        """Why there is none."""
        return self.near_zero or self.note

    @property
    def note(self) -> str:
        """All remarks as one text; may be empty."""
        return "; ".join(self.remarks)


def mean_over_seeds(values: Sequence[float], missing: str | None = None, bounds: Bounds = UNBOUNDED) -> Estimate:
    """The mean of one value per seed.

    Args:
        values: Finite.
        missing: Why there is not a value of every seed; becomes the last note. None if there is.
        bounds: What a value can be; the interval allows for one more at either end, see `harness.eta.interval`.
    """
    reasons = () if missing is None else (missing,)
    if not values:
        return Estimate(None, notes=reasons)
    mean, seeds = float(np.mean(values)), len(values)
    if too_few := why_no_interval(seeds):
        return Estimate(mean, seeds=seeds, notes=(*too_few, *reasons))
    low, high = cut_to(mean_bounds(Side([np.asarray(values, np.float64)], [bounds]), CONFIDENCE), bounds)
    return Estimate(mean, low, high, seeds, reasons)


def mean_of_known(values: Sequence[float | None], missing: str, bounds: Bounds = UNBOUNDED) -> Estimate:
    """The mean over those seeds that have a value; how many have none is told, with `missing` behind it."""
    known = [value for value in values if value is not None]
    told = f"{len(values) - len(known)} of {len(values)} {missing}" if len(known) < len(values) else None
    return mean_over_seeds(known, told, bounds)
