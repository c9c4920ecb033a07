"""Labels dealt anew: which trainings could as well have carried the proposed reward's name.

Trainings are not paired: those of one seed under two rewards end no more alike than any two. So if the rewards do not
differ, any of the trainings could be the proposed reward's, as many as it has. A test deals the labels in all ways that
there are, or in many drawn ones, and asks how often chance alone gives as much as was seen (Fisher 1935).
"""

import itertools
import math
from functools import lru_cache
from typing import TypeAlias

import numpy as np

from harness.arrays import Float

MOST_DEALS = 20_000
"""Where there are more ways than these, so many are drawn."""
SEED = 105

Strata: TypeAlias = tuple[tuple[int, int, int], ...]
"""Trainings among which labels are dealt: a number that names the stratum, and how many of the baseline and of the
proposed reward are in it. Where one of them has none there is one way."""


def deals_of(strata: Strata) -> Float:
    """Ways to deal the labels, the same for equal strata in every comparison and in every report.

    Args:
        strata: The labels of a stratum stay in it.

    Returns:
        (ways, trainings): 1 where a training carries the proposed reward's name, 0 where the baseline's. The first way
        is as they were trained. The columns are, for each stratum, its baselines and then its proposed ones.
    """
    return _deals(strata, count_deals(strata) > MOST_DEALS)


def as_trained(strata: Strata) -> Float:
    """The labels that the trainings have: in each stratum 0 of its baselines, then 1 of its proposed ones."""
    labels: Float = np.concatenate([np.zeros(0), *(np.repeat([0.0, 1.0], counts) for _, *counts in strata)])
    return labels


def count_deals(strata: Strata) -> int:
    """How many ways there are."""
    return math.prod(math.comb(baselines + proposed, proposed) for _, baselines, proposed in strata)


@lru_cache(maxsize=8)
def _deals(strata: Strata, is_drawn: bool) -> Float:
    drawn = [_drawn_in(*stratum) for stratum in strata] if is_drawn else [_all(strata)]
    dealt = drawn[0] if len(drawn) == 1 else np.concatenate(drawn, axis=1)  # of many seeds a copy is large
    dealt.setflags(write=False)
    return dealt


def _drawn_in(name: int, baselines: int, proposed: int) -> Float:
    dealt: Float = np.tile(as_trained(((name, baselines, proposed),)), (MOST_DEALS, 1))
    counts = [baselines] if baselines == proposed else [baselines, proposed]
    np.random.default_rng([SEED, name, *counts]).permuted(dealt[1:], axis=1, out=dealt[1:])
    return dealt


def _all(strata: Strata) -> Float:
    """All ways: every choice in one stratum beside every choice in each other one."""
    choices = [_all_in(baselines, proposed) for _, baselines, proposed in strata]
    rows = itertools.product(*(range(len(choice)) for choice in choices))
    index = np.array(list(rows), dtype=np.intp).reshape(-1, len(choices))
    return np.concatenate([choice[index[:, at]] for at, choice in enumerate(choices)], axis=1)


def _all_in(baselines: int, proposed: int) -> Float:
    """All choices of so many proposed ones; as they were trained comes first."""
    trainings = baselines + proposed
    chosen = np.array(list(itertools.combinations(range(trainings - 1, -1, -1), proposed)), np.intp)
    ways: Float = np.zeros((len(chosen), trainings))
    np.put_along_axis(ways, chosen.reshape(len(chosen), proposed), 1.0, axis=1)
    return ways
