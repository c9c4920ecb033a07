"""Labels dealt anew: which trainings could as well have carried the proposed reward's name.

Trainings are not paired: those of one seed under two rewards end no more alike than any two. So if the rewards do not
differ, any half of the trainings could be the proposed reward's. A test deals the labels in all ways that there are,
or in many drawn ones, and asks how often chance alone gives as much as was seen (Fisher 1935).
"""

import itertools
import math
from collections.abc import Sequence
from functools import lru_cache
from typing import TypeAlias

import numpy as np

from harness.arrays import Float

MOST_DEALS = 20_000
"""Where there are more ways than these, so many are drawn."""
SEED = 105

Strata: TypeAlias = tuple[tuple[int, int], ...]
"""Trainings among which labels are dealt: a number that names the stratum, and how many of each reward are in it."""


def deals_of(strata: Strata, is_drawn: bool = False) -> Float:
    """Ways to deal the labels, the same for equal strata in every comparison and in every report.

    Args:
        strata: The labels of a stratum stay in it.
        is_drawn: Whether ways are drawn even where all could be tried. Ways that are drawn stay the same for a stratum
            when others come behind it.

    Returns:
        (ways, trainings): 1 where a training carries the proposed reward's name, 0 where the baseline's. The first way
        is as they were trained. The columns are, for each stratum, its baselines and then its proposed ones.
    """
    return _deals(strata, is_drawn or count_deals(strata) > MOST_DEALS)


def count_deals(strata: Strata) -> int:
    """How many ways there are."""
    return math.prod(math.comb(2 * seeds, seeds) for _, seeds in strata)


def smallest_p(seeds: int, places: int = 1) -> float:
    """The smallest two-sided p of so many seeds of each reward, in each of so many places that share none."""
    ways = min(math.comb(2 * seeds, seeds), 2 * MOST_DEALS)  # of 1,000 seeds they are more than a float can say
    return max(2.0 * float(ways) ** -places, 1.0 / MOST_DEALS)


@lru_cache(maxsize=8)
def _deals(strata: Strata, is_drawn: bool) -> Float:
    drawn = _drawn(strata) if is_drawn else [_all(strata)]
    dealt = drawn[0] if len(drawn) == 1 else np.concatenate(drawn, axis=1)  # of many seeds a copy is large
    dealt.setflags(write=False)
    return dealt


def _drawn(strata: Strata) -> Sequence[Float]:
    return [_drawn_in(name, seeds) for name, seeds in strata]


def _drawn_in(name: int, seeds: int) -> Float:
    dealt: Float = np.tile(np.repeat([0.0, 1.0], seeds), (MOST_DEALS, 1))
    np.random.default_rng([SEED, name, seeds]).permuted(dealt[1:], axis=1, out=dealt[1:])
    return dealt


def _all(strata: Strata) -> Float:
    """All ways: every choice in one stratum beside every choice in each other one."""
    choices = [_all_in(seeds) for _, seeds in strata]
    rows = itertools.product(*(range(len(choice)) for choice in choices))
    index = np.array(list(rows), dtype=np.intp).reshape(-1, len(choices))
    return np.concatenate([choice[index[:, at]] for at, choice in enumerate(choices)], axis=1)


def _all_in(seeds: int) -> Float:
    """All choices of half of the trainings; as they were trained comes first."""
    chosen = list(itertools.combinations(range(2 * seeds - 1, -1, -1), seeds))
    ways: Float = np.zeros((len(chosen), 2 * seeds))
    ways[np.arange(len(chosen))[:, None], chosen] = 1.0
    return ways
