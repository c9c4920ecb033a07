"""What a split of eta holds: its ruler, its behaviour, and how both etas of a comparison come to be."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from harness.arrays import Float
from harness.eta.curve import GroupCurve
from harness.eta.index import Estimate, Index
from harness.eta.interval import Sums
from harness.files.plain import Plain, tells

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


DISAGREEMENT = 1.5
"""Two answers to one question disagree where they differ by more than this factor."""
NOT_MEASURED = Estimate(None, notes=("not measured",))


class Names(NamedTuple):
    """Labels of the two rewards."""

    baseline: str
    proposed: str


class SplitPath(NamedTuple):
    """One of the two ways to split an eta."""

    ruler: Estimate
    behaviour: Estimate


@tells("eta", "per_seed", "ruler", "behaviour", "interaction", "noise", "paths", "p", "p_corrected=corrected", "flags")
@dataclass(frozen=True)
class Split(Plain):
    """One index's eta, and what it is made of.

    Attributes:
        eta: Of the mean curves, as published.
        per_seed: Geometric mean over seeds of the eta of each seed alone.
        ruler: Geometric mean of both paths' rulers.
        behaviour: Geometric mean of both paths' behaviours.
        interaction: Ruler on the proposed runs over ruler on the baseline's.
        paths: On the proposed runs, then on the baseline's; empty where the runs were not scored by both rewards.
        noise: What runs of the baseline give against other runs of it; see `harness.eta.decomposition`.
        p: That there is no difference between the two groups' curves, by an exact test; None where it cannot be told.
        corrected: The same, such that it holds for all claims that are made together.
        outcomes: The difference of the index, the names of the trainings swapped in all ways; see `harness.eta.swaps`.
    """

    eta: Estimate
    per_seed: Estimate
    ruler: Estimate
    behaviour: Estimate
    interaction: Estimate
    paths: tuple[SplitPath, ...] = ()
    noise: Estimate = NOT_MEASURED
    p: float | None = None
    corrected: float | None = None
    outcomes: Float | None = field(default=None, repr=False, compare=False)

    @property
    def is_scored(self) -> bool:
        """Whether each training was scored by the other's reward."""
        return bool(self.paths)

    @property
    def opposition(self) -> str:
        """A sentence if one path says that the behaviour got better and the other that it got worse; else empty."""
        parts = [path.behaviour for path in self.paths]
        values = [part.value for part in parts if part.near_zero is None and part.value is not None]
        if len(values) < 2 or (values[0] - 1.0) * (values[1] - 1.0) >= 0.0:
            return ""
        return (
            f"the behaviour depends on who judges it: x {values[0]:.3g} under the baseline reward, x {values[1]:.3g} "
            "under the proposed one"
        )

    @property
    def averaging(self) -> str:
        """A sentence if the mean curve says something else than the seeds do one by one; else empty."""
        whole, single = self.eta.value, self.per_seed.value
        if whole is None or single is None or self.eta.near_zero is not None or min(whole, single) <= 0.0:
            return ""
        opposed = (whole - 1.0) * (single - 1.0) < 0.0
        if not opposed and abs(math.log(whole / single)) < math.log(DISAGREEMENT):
            return ""
        return f"{whole:.3g} of the mean curve is not what seeds show one by one: their geometric mean is {single:.3g}"

    @property
    def flags(self) -> tuple[str, ...]:
        """What stands in the way of one answer."""
        return tuple(flag for flag in (self.averaging, self.opposition) if flag)


Splits: TypeAlias = Mapping[str, Split]
"""By ``eta_N`` and ``eta_P``."""


@dataclass(frozen=True)
class SumSplit(Plain):
    """The change of I_N + I_P, NOTE eq. 38, proposed - baseline: ruler + behaviour, each a mean over seeds.

    Attributes:
        change: All of it.
        ruler: Of it the same runs scored by the other reward, mean of both paths.
        behaviour: Of it the two trainings scored by one reward, mean of both paths.
    """

    change: Estimate
    ruler: Estimate
    behaviour: Estimate


@tells("baseline", "proposed", "*splits", "total")
@dataclass(frozen=True)
class Decomposition(Plain):
    """Both etas, split.

    Attributes:
        baseline: Index of the baseline's runs under the baseline.
        proposed: Index of the proposed reward's runs under it.
        negative: The split of eta_N.
        positive: The split of eta_P.
        total: The split of the change of I_N + I_P.
    """

    baseline: Index
    proposed: Index
    negative: Split
    positive: Split
    total: SumSplit

    @property
    def eta_n(self) -> Estimate:
        """NOTE eq. 43; below 1 is called better."""
        return self.negative.eta

    @property
    def eta_p(self) -> Estimate:
        """NOTE eq. 44; above 1 is called better."""
        return self.positive.eta

    @property
    def is_split(self) -> bool:
        """Whether each training was scored by the other's reward."""
        return self.negative.is_scored

    @property
    def splits(self) -> Splits:
        """Both splits."""
        return {"eta_N": self.negative, "eta_P": self.positive}

    def with_corrected(self, negative: float | None, positive: float | None) -> "Decomposition":
        """The same with p-values that hold for all claims that are made together."""
        return replace(
            self,
            negative=replace(self.negative, corrected=negative),
            positive=replace(self.positive, corrected=positive),
        )


def no_splits(reason: str) -> Splits:
    """Where there is nothing to compare."""
    nothing = Estimate(None, notes=(reason,))
    empty = Split(nothing, nothing, nothing, nothing, nothing, noise=nothing)
    return {"eta_N": empty, "eta_P": empty}
