"""The logarithmic axis that ratios stand on."""

import math
from collections.abc import Sequence
from itertools import pairwise

from harness.eta.index import Ratio
from harness.report.rows.ratios import is_drawable

FARTHEST = 30.0
"""An interval is drawn at most this factor beyond the outermost ratio. Numbers beside it say where it ends."""
TICKS = ((0.45, (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 9)), (1.0, (1, 1.5, 2, 3, 5, 7)), (2.2, (1, 2, 5)))
"""Which digits are marked if the axis spans at most so many decades. On a longer axis only powers of ten are marked."""

ROOM = 26
"""The fewest characters that have room along the axis, since numbers with their intervals may stand beside it."""


def ratio_range(ratios: Sequence[Ratio]) -> tuple[float, float]:
    """The range of the axis: every ratio, every interval up to `FARTHEST`, 1, and some margin."""
    drawn = [ratio for ratio in ratios if is_drawable(ratio)]
    values = [ratio.value for ratio in drawn if ratio.value is not None]
    ends = [end for ratio in drawn for end in (ratio.low, ratio.high) if end is not None]
    low, high = min([0.85, *values]), max([1.18, *values])
    low = min([low, *(max(end, low / FARTHEST) for end in ends)])
    high = max([high, *(min(end, high * FARTHEST) for end in ends)])
    air = (high / low) ** 0.08
    return low / air, high * air


def interval_ends(ratio: Ratio, low: float, high: float) -> tuple[float, float] | None:
    """The ends of a ratio's interval on an axis from `low` to `high`; None if it has no interval."""
    if ratio.low is None or ratio.high is None:
        return None
    return max(ratio.low, low), min(ratio.high, high)


def ticks(low: float, high: float) -> list[float]:
    """Round numbers between `low` and `high`, few enough to be read. 1 is among them if it lies in the range."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    decades = math.log10(high / low)
    digits = next((digits for most, digits in TICKS if decades <= most), None)
    if digits is None:
        step = math.ceil(decades / 6)
        values = [10.0**power for power in range(first, last + 1) if power % step == 0]
    else:
        values = [digit * 10.0**power for power in range(first, last + 1) for digit in digits]
    return [float(f"{value:.3g}") for value in values if low <= value <= high]


def named_ticks(low: float, high: float) -> tuple[tuple[float, str], ...]:
    """The `ticks` whose names have room. Every second one is left out until no names touch; 1 always stays."""
    marks = ticks(low, high)
    while len(marks) > 2 and any(_touch(*pair, high / low) for pair in pairwise(marks)):
        marks = marks[marks.index(1.0) % 2 :: 2]
    return tuple((mark, _name(mark)) for mark in marks)


def _touch(left: float, right: float, span: float) -> bool:
    """Whether the names of two ticks are less than a character apart, on an axis of which `span` is high over low."""
    apart = ROOM * math.log(right / left) / math.log(span)
    return apart < (len(_name(left)) + len(_name(right))) / 2 + 1


def _name(mark: float) -> str:
    """The name of a tick: its number. A power of ten that is long in digits is written like 1e-4 or 1e5."""
    return f"{mark:,g}" if 0.001 <= mark <= 1_000 else f"1e{math.log10(mark):.0f}"
