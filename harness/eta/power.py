"""How many seeds are needed to tell a difference of a given size."""

import math
from typing import TypeAlias

from harness.eta.interval import spread_range

POWER = 0.8
MOST = 10_000
FEWEST = 4
"""Fewer seeds of each reward cannot show anything in one place, neither by a bound nor by labels dealt anew."""
Range: TypeAlias = tuple[int, int]


def range_text(seeds: Range) -> str:
    """A range of whole numbers; of one number that number."""
    low, high = seeds
    return f"{low:,}" if low == high else f"{low:,} to {high:,}"


def seeds_to_tell(difference: float, spread: float, seeds: int, confidence: float, reach: float = 0.0) -> Range | None:
    """How many seeds of each reward give a plain word in four of five experiments, as a range.

    The spread over few seeds is known only roughly. The low end takes the smallest likely spread, the high end the
    largest.

    Args:
        difference: The size, above 0.
        spread: Standard deviation of one training.
        seeds: How many seeds of each reward `spread` comes from, at least 2; the fewer where one reward has more.
        confidence: That of the bound that has to leave out 0, see `harness.eta.interval`.
        reach: How far the training that was not seen can lie from the mean of its reward.

    Returns:
        Lowest and highest number; None if more than `MOST` would be needed.
    """
    found = [_seeds_for(difference, it, confidence, reach) for it in spread_range(spread, 2 * seeds - 1)]
    return None if found[1] is None or found[0] is None else (found[0], found[1])


def _seeds_for(difference: float, spread: float, confidence: float, reach: float) -> int | None:
    """The fewest seeds with enough power."""
    low, high = FEWEST, MOST
    if not _is_told(difference, spread, high, confidence, reach):
        return None
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if _is_told(difference, spread, middle, confidence, reach) else (middle + 1, high)
    return low


def _is_told(difference: float, spread: float, seeds: int, confidence: float, reach: float) -> bool:
    """Whether the bound leaves out 0 with the power that is asked for, where the spread is what was seen."""
    from scipy.special import ndtri, stdtrit

    begun = seeds + (reach > 0.0)
    ours = ((seeds - 1) * spread**2 + reach**2 * seeds / begun * (reach > 0.0)) / (begun - 1) / begun
    theirs = spread**2 / seeds
    freedom = (ours + theirs) ** 2 / (ours**2 / (begun - 1) + theirs**2 / (seeds - 1)) if spread or reach else 1.0
    beyond = difference - reach / begun - float(stdtrit(freedom, 0.5 + confidence / 2.0)) * math.sqrt(ours + theirs)
    return beyond > float(ndtri(POWER)) * spread * math.sqrt(2.0 / seeds)
