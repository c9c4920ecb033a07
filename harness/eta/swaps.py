"""Exact tests: what would have come out, had the two rewards changed places in some seeds.

Without any difference between two trainings of a seed it is chance which of them is called the proposed one. A test
swaps these names in all ways that there are and asks in how many of them the difference is at least as large as the
one seen (Fisher 1935). It assumes no distribution: seeds may be as skewed as they like.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from harness.arrays import Float, Mask

ALL_UP_TO = 13
"""Up to this many seeds all ways are tried, 4,096; of more seeds, so many drawn ways."""
DRAWN = 4_096
SEED = 105
ALPHA = 0.05


@dataclass(frozen=True, eq=False)
class Swaps:
    """Ways to give the names of both trainings, a row each.

    Attributes:
        signs: (ways, seeds): 1 keeps the names of a seed, -1 swaps them. The first row keeps all. Swapping all seeds
            turns the sign of a difference only, so one of two opposite ways is enough.
        seeds: Of each column.
    """

    signs: Float
    seeds: tuple[int, ...]

    def of(self, seeds: Sequence[int]) -> Float:
        """The columns of some seeds, (ways, len(seeds))."""
        return _columns(self, tuple(seeds))


@lru_cache(maxsize=2)
def _columns(swaps: Swaps, seeds: tuple[int, ...]) -> Float:
    """Nearly all measures of a comparison have the same seeds; of many seeds they take megabytes."""
    place = {seed: column for column, seed in enumerate(swaps.seeds)}
    columns: Float = swaps.signs[:, [place[seed] for seed in seeds]]
    columns.setflags(write=False)
    return columns


def swaps_of(seeds: Sequence[int]) -> Swaps:
    """All ways for up to `ALL_UP_TO` seeds; for more, `DRAWN` of them, the same in every report."""
    count = len(seeds)
    if count <= ALL_UP_TO:
        ways = np.arange(2 ** max(0, count - 1), dtype=np.int64)[:, None] >> np.arange(count)[None, :] & 1
    else:
        ways = np.random.default_rng([SEED, count]).integers(0, 2, (DRAWN, count))
        ways[0] = 0
    signs: Float = np.where(ways, -1.0, 1.0)
    return Swaps(signs, tuple(seeds))


def p_of(outcomes: Float) -> float:
    """Two-sided p-value: in which share of the ways the difference is at least as large as the one seen.

    Args:
        outcomes: The difference in every way, (ways,), the one seen first.
    """
    return float(np.mean(_reaches(np.abs(outcomes), abs(outcomes[0]))))


def corrected_p(outcomes: Sequence[Float]) -> list[float]:
    """p-values that hold for several claims together: Westfall and Young's step-down procedure (1993).

    It is Holm's procedure with the claims' own joint distribution in place of the worst case: all claims of a seed are
    swapped together, so measures that say the same thing twice cost once. The chance that any claim without a
    difference gets a p-value of at most alpha is at most alpha.

    Args:
        outcomes: Of each claim the difference in every way, (ways,), the one seen first; the same ways for all.

    Returns:
        One p-value per claim.
    """
    if not outcomes:
        return []
    scaled = np.stack([_scaled(claim) for claim in outcomes])
    order = np.argsort(-scaled[:, 0], kind="stable")
    # From the weakest claim up: what the largest of all claims no stronger than this one gives in every way.
    largest = np.maximum.accumulate(scaled[order[::-1]])[::-1]
    corrected, so_far = [0.0] * len(order), 0.0
    for rank, claim in enumerate(order):
        so_far = max(so_far, float(np.mean(_reaches(largest[rank], scaled[claim, 0]))))
        corrected[claim] = so_far
    return corrected


def corrected_where_known(claims: Sequence[Float | None]) -> list[float | None]:
    """The same of the claims whose outcomes are known; None for the others."""
    corrected = iter(corrected_p([claim for claim in claims if claim is not None]))
    return [None if claim is None else next(corrected) for claim in claims]


def label_shares(baseline: int, proposed: int) -> Float:
    """How much each run counts where runs are not paired: their labels are dealt out anew, the first way keeps them.

    Returns:
        (DRAWN, baseline + proposed): for the proposed side if positive, else for the baseline's.
    """
    labels = np.repeat([-1.0 / baseline, 1.0 / proposed], [baseline, proposed])
    shares = np.tile(labels, (DRAWN, 1))
    shares[1:] = np.random.default_rng([SEED, baseline, proposed]).permuted(shares[1:], axis=1)
    return shares


def _scaled(claim: Float) -> Float:
    """Sizes in units of the claim's own spread over all ways: claims with different units can be compared."""
    spread = float(np.sqrt(np.mean(claim**2)))
    sizes: Float = np.abs(claim) / spread if spread > 0.0 else np.zeros_like(claim)
    return sizes


def _reaches(sizes: Float, seen: float) -> Mask:
    """Whether each is at least as large as the one seen; sums of floats in another order may differ in the last bit."""
    reached: Mask = sizes >= seen - 1e-9 * sizes.max()
    return reached


def p_text(p: float | None) -> str:
    """A p-value in a sentence or a table; one that is just above `ALPHA` is not rounded to it."""
    if p is None or p < 0.001:
        return "n/a" if p is None else "< 0.001"
    return f"{p:.4f}" if ALPHA < p < ALPHA + 0.0005 else f"{p:.3f}"


def luck_text(p: float) -> str:
    """A p-value in words."""
    count = "fewer than 1" if p < 0.001 else f"{1000.0 * float(p_text(p)):g}"
    return f"If the rewards did not differ, {count} of 1,000 experiments would show such a difference."
