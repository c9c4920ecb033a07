"""How many seeds are needed to tell a difference of a given size."""

import math
from functools import lru_cache
from typing import TypeAlias

from harness.eta.interval import spread_range
from harness.eta.verdict.deals import MOST_DEALS

POWER = 0.8
MOST = 10_000
Range: TypeAlias = tuple[int, int]


def seeds_to_tell(difference: float, spread: float, seeds: int, asked: int, level: float) -> Range | None:
    """How many seeds of each reward show a difference of this size in four of five experiments, as a range.

    The spread over few seeds is known only roughly, and what the correction for several questions costs depends on how
    alike they are. The low end takes the smallest likely spread and no correction, the high end the largest likely
    spread and Bonferroni's correction, which is never too small.

    Args:
        difference: The size, above 0.
        spread: Standard deviation of one training.
        seeds: How many seeds of each reward `spread` comes from, at least 2; the fewer where one reward has more.
        asked: How many tests share the level: questions that are asked together, times the measures that decide each.
            Where one of three measures shows a difference, the high end is still enough.
        level: The chance of a false answer to any of them.

    Returns:
        Lowest and highest number; None if more than `MOST` would be needed.
    """
    smallest, largest = spread_range(spread, 2 * seeds - 1)
    low = _seeds_for(difference, smallest, level)
    high = _seeds_for(difference, largest, level / max(1, asked))
    return None if low is None or high is None else (low, high)


@lru_cache(maxsize=64)
def fewest_seeds(level: float) -> int:
    """Fewer seeds of each reward than these cannot show anything in one place: 4 at 0.05."""
    seeds = 2
    while 2.0 / math.comb(2 * seeds, seeds) > level:
        seeds += 1
    return seeds


def _seeds_for(difference: float, spread: float, level: float) -> int | None:
    """The fewest seeds with enough power. Dealing labels anew has the power of Student's t at the level it reaches."""
    low, high = fewest_seeds(level), MOST
    if _power(difference, spread, high, level) < POWER:
        return None
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if _power(difference, spread, middle, level) >= POWER else (middle + 1, high)
    return low


def _power(difference: float, spread: float, seeds: int, level: float) -> float:
    """Chance that so many seeds of each reward show the difference."""
    from scipy.special import nctdtr, stdtrit

    if spread == 0.0:
        return 1.0
    freedom = 2 * seeds - 2
    critical = float(stdtrit(freedom, 1.0 - _reached(level, seeds) / 2.0))
    missed = float(nctdtr(freedom, difference / spread * math.sqrt(seeds / 2.0), critical))
    return 1.0 if math.isnan(missed) else 1.0 - missed  # if scipy returns NaN, the chance to miss is almost 0


def _reached(level: float, seeds: int) -> float:
    """The largest possible p-value up to a level with so many seeds, such as 0.029 for 4 seeds at 0.05."""
    ways = min(math.comb(2 * seeds, seeds) / 2.0, MOST_DEALS) if seeds < 20 else MOST_DEALS
    return math.floor(level * ways) / ways
