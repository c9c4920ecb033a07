"""The indices of two trainings under both rewards, with all seeds and without each of them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from harness.arrays import Float
from harness.eta.curve import GroupCurve
from harness.eta.interval import Sums

Who: TypeAlias = Literal["baseline", "proposed"]
Pair: TypeAlias = tuple[Who, Who]
"""The reward that scores, and the reward whose runs are scored: S_r(tau_q) is (r, q)."""

BB: Pair = ("baseline", "baseline")
KK: Pair = ("proposed", "proposed")
BK: Pair = ("baseline", "proposed")
KB: Pair = ("proposed", "baseline")

Curves: TypeAlias = Mapping[Pair, GroupCurve]


@dataclass(frozen=True, eq=False)
class ScoredSums:
    """One index, or the sum of both, for every group of runs under every reward that scored it.

    Attributes:
        whole: The index with all seeds, each (1,).
        without: The index without one run of the group at a time, each (runs,); empty for a single run.
        each: The index of every run alone, each (runs,).
        paired: Whether run i of both trainings has the same seed: leaving one out leaves both out.
    """

    whole: Sums
    without: Sums
    each: Sums
    paired: bool

    @property
    def left_out(self) -> tuple[Sums, ...]:
        """The indices without one seed at a time: one entry for pairs, else one for the seeds of each training."""
        return _left_out(self.whole, self.without, self.paired)

    def geometric(self) -> tuple[Sums, tuple[Sums, ...]]:
        """Geometric means of single runs' sizes, either training under its own reward: with all runs, without each.

        Takes runs that are not 0.
        """
        sizes = {pair: np.log(np.abs(self.each[pair])) for pair in (BB, KK)}
        whole = {pair: np.exp([size.mean()]) for pair, size in sizes.items()}
        without = {pair: np.exp(means_without_each(size)) for pair, size in sizes.items()}
        return whole, _left_out(whole, without, self.paired)

    def value(self, pair: Pair) -> float:
        """The value from all seeds."""
        return float(self.whole[pair][0])


def scored_sums(curves: Curves, paired: bool) -> tuple[ScoredSums, ScoredSums, ScoredSums]:
    """I_N, I_P and I_N + I_P, NOTE eq. 38 and 41-42, before rounding.

    Args:
        curves: S_r(tau_q) by (r, q).
        paired: Run i of both trainings has the same seed.
    """
    whole = {pair: np.array([[curve.index.negative_sum], [curve.index.positive_sum]]) for pair, curve in curves.items()}
    without = {
        pair: np.stack(curve.left_out()) if curve.count > 1 else np.empty((2, 0)) for pair, curve in curves.items()
    }
    each = {pair: np.stack(curve.each()) for pair, curve in curves.items()}

    def weighted(negative: float, positive: float) -> ScoredSums:
        weights = np.array([negative, positive])
        return ScoredSums(_weigh(weights, whole), _weigh(weights, without), _weigh(weights, each), paired)

    return weighted(1.0, 0.0), weighted(0.0, 1.0), weighted(1.0, 1.0)


def _weigh(weights: Float, given: Sums) -> Sums:
    return {pair: weights @ sums for pair, sums in given.items()}


def _left_out(whole: Sums, without: Sums, paired: bool) -> tuple[Sums, ...]:
    if paired:
        return (without,)
    return tuple(
        {
            pair: without[pair] if pair[1] == trained else np.repeat(whole[pair], len(without[trained, trained]))
            for pair in whole
        }
        for trained in ("baseline", "proposed")
    )


def means_without_each(values: Float) -> Float:
    """The mean without each of the values, (count,); empty for a single one."""
    if len(values) == 1:
        return np.empty(0)
    means: Float = (values.sum() - values) / (len(values) - 1)
    return means
