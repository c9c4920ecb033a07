"""How many seeds are needed to tell a difference of a given size."""

import math
from typing import TypeAlias

from harness.eta.interval import spread_range
from harness.eta.swaps import ALPHA, fewest_seeds

POWER = 0.8
MOST = 10_000
Range: TypeAlias = tuple[int, int]


def seeds_to_tell(difference: float, spread: float, seeds: int, claims: int) -> Range | None:
    """How many seeds show a difference of this size in four of five experiments, as a range.

    The spread over few seeds is known only roughly, and what the correction for several claims costs depends on how
    alike they are. The low end takes the smallest likely spread and no correction, the high end the largest likely
    spread and Bonferroni's correction, which is never too small.

    Args:
        difference: The size, above 0.
        spread: Standard deviation of the difference of a seed.
        seeds: How many seeds `spread` comes from, at least 2.
        claims: How many claims are made together.

    Returns:
        Lowest and highest number; None if more than `MOST` would be needed.
    """
    smallest, largest = spread_range(spread, seeds)
    low = _seeds_for(difference, smallest, ALPHA)
    high = _seeds_for(difference, largest, ALPHA / max(1, claims))
    return None if low is None or high is None else (low, high)


def _seeds_for(difference: float, spread: float, alpha: float) -> int | None:
    """The fewest seeds with enough power. Swapping seeds has the power of Student's t at the level that it reaches."""
    low, high = fewest_seeds(alpha), MOST
    if _power(difference, spread, high, alpha) < POWER:
        return None
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if _power(difference, spread, middle, alpha) >= POWER else (middle + 1, high)
    return low


def _power(difference: float, spread: float, seeds: int, alpha: float) -> float:
    """Chance that so many seeds show the difference."""
    from scipy.special import nctdtr, stdtrit

    if spread == 0.0:
        return 1.0
    critical = float(stdtrit(seeds - 1, 1.0 - _reached(alpha, seeds) / 2.0))
    missed = float(nctdtr(seeds - 1, difference / spread * seeds**0.5, critical))
    return 1.0 if math.isnan(missed) else 1.0 - missed  # if scipy returns NaN, the chance to miss is almost 0


def _reached(alpha: float, seeds: int) -> float:
    """The largest possible p-value up to alpha with so many seeds, such as 0.031 for 6 seeds at 0.05."""
    ways = 2.0 ** min(seeds - 1, 50)  # beyond that any p-value can be reached, and the power is no float any more
    return math.floor(alpha * ways) / ways
