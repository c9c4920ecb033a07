"""The logarithmic axis that ratios stand on, however it is drawn."""

import math
from collections.abc import Sequence

from harness.eta.index import Ratio

FARTHEST = 1_000.0
"""An interval is drawn no farther than this factor beyond the outermost ratio."""
TICKS = ((0.45, (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 9)), (1.0, (1, 1.5, 2, 3, 5, 7)), (2.2, (1, 2, 5)))
"""Which digits are marked while the axis spans at most so many decades; beyond, powers of ten."""


def is_drawable(ratio: Ratio) -> bool:
    """A logarithm has no place for 0, and a ratio that says little would stretch the axis."""
    return ratio.value is not None and ratio.value > 0.0 and ratio.near_zero is None


def ratio_range(ratios: Sequence[Ratio], farthest: float = FARTHEST) -> tuple[float, float]:
    """What the axis spans: every ratio and interval that is drawn, the latter up to `farthest`, 1, and some air."""
    drawn = [ratio for ratio in ratios if is_drawable(ratio)]
    values = [ratio.value for ratio in drawn if ratio.value is not None]
    ends = [end for ratio in drawn for end in (ratio.low, ratio.high) if end is not None]
    low, high = min([0.85, *values]), max([1.18, *values])
    low = min([low, *(max(end, low / farthest) for end in ends)])
    high = max([high, *(min(end, high * farthest) for end in ends)])
    air = (high / low) ** 0.08
    return low / air, high * air


def interval_ends(ratio: Ratio, low: float, high: float) -> tuple[float, float] | None:
    """Where its interval is drawn on an axis from `low` to `high`; None if it has none."""
    if ratio.low is None or ratio.high is None:
        return None
    return max(ratio.low, low), min(ratio.high, high)


def ticks(low: float, high: float) -> list[float]:
    """Round numbers between `low` and `high`, few enough to be read; 1 among them if it is there."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    decades = math.log10(high / low)
    digits = next((digits for most, digits in TICKS if decades <= most), None)
    if digits is None:
        step = math.ceil(decades / 6)
        values = [10.0**power for power in range(first, last + 1) if power % step == 0]
    else:
        values = [digit * 10.0**power for power in range(first, last + 1) for digit in digits]
    return [float(f"{value:.3g}") for value in values if low <= value <= high]
