"""How much of eta is only a change of ruler, and how much is behaviour.

With S_r(tau_q) the index of the runs trained under reward q and scored by reward r (B baseline, K proposed)::

    eta = S_K(tau_K) / S_B(tau_B)
        = [S_K(tau_K) / S_B(tau_K)] x [S_B(tau_K) / S_B(tau_B)]        r1 x b1, the ruler on the proposed runs
        = [S_K(tau_B) / S_B(tau_B)] x [S_K(tau_K) / S_K(tau_B)]        r2 x b2, the ruler on the baseline's runs

The split that is shown is their geometric mean, ruler = sqrt(r1 r2) and behaviour = sqrt(b1 b2): the ideal index of
Fisher (1922), and of two factors the Shapley value of their logarithms (Shorrocks 2013). It is the same whichever
reward is called the baseline. r1 / r2 is the interaction: 1 where both paths agree. Where an index crosses 0 no ratio
says much: the sum I_N + I_P (NOTE eq. 38) is split by differences (Kitagawa 1955), which are always defined.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property
from statistics import NormalDist

import numpy as np

from harness.arrays import Float
from harness.eta.curve import GroupCurve, mixtures, swapped
from harness.eta.index import Estimate
from harness.eta.interval import (
    CONFIDENCE,
    Jackknife,
    Sums,
    jackknife,
    quantile,
    spread_range,
    why_no_interval,
)
from harness.eta.splits import (
    BB,
    BK,
    KB,
    KK,
    Curves,
    Decomposition,
    Pair,
    ScoredSums,
    Split,
    SplitPath,
    SumSplit,
    scored_sums,
)
from harness.eta.swaps import label_shares, p_of, swaps_of

OWNER = {
    BB: "the baseline",
    KK: "the proposed reward",
    BK: "the proposed runs under the baseline reward",
    KB: "the baseline runs under the proposed reward",
}
ZERO = {
    ("accumulated", "I_N"): "its mean accumulated reward is never negative",
    ("accumulated", "I_P"): "its mean accumulated reward is never positive",
    ("per-step", "I_N"): "its mean reward is never negative",
    ("per-step", "I_P"): "its mean reward has nothing after a cross-over",
}
"""What an index of 0 means."""
NEAR_ZERO = 0.01
"""An index below this share of the other training's under the same reward counts as 0: a ratio with it says little.
Under another reward it may be small because the ruler is."""
NEGLIGIBLE = 1e-4
"""So does an index below this share of its curve's other index. In published curves I_N is 0.003 of I_P."""
ROUNDING = 1e-12
"""Two indices that differ by less than this share differ only by the order of additions."""
UNLIKE = 1.0
"""Standard deviation of the logarithm of single seeds' indices beyond which a ruler's interval does not hold, by
simulation. As few seeds know theirs only roughly, the largest likely one counts."""


def decompose(
    curves: Curves,
    paired: bool = True,
    missing: str | None = None,
    signs: Float | None = None,
    control: GroupCurve | None = None,
) -> Decomposition:
    """Both etas with intervals, and how they split.

    Args:
        curves: S_r(tau_q) by (r, q); at least (baseline, baseline) and (proposed, proposed). With the other two the
            etas are split; runs of one training have the same order under both scorings.
        paired: Run i of both trainings has the same seed.
        missing: Why the other two are not there; None where they are, or nobody asked.
        signs: In which ways the names of a seed's trainings are swapped, see `harness.eta.swaps`; by default in all.
        control: The baseline trained again with other seeds, scored by itself.
    """
    one, other = curves[BB], curves[KK]
    paired = paired and one.count == other.count
    sums = scored_sums(curves, paired)
    outcomes = _outcomes(one, other, paired, signs)
    splits = (
        Splitter(name, sums[which], ZERO[one.kind, name], sums[1 - which]).split(outcomes[which], missing)
        for which, name in enumerate(("I_N", "I_P"))
    )
    negative, positive = (replace(split, noise=noise_floor(one, control, which)) for which, split in enumerate(splits))
    return Decomposition(one.index, other.index, negative, positive, split_sum(sums[2], missing))


def _outcomes(one: GroupCurve, other: GroupCurve, paired: bool, signs: Float | None) -> tuple[Float | None, ...]:
    """Differences of I_N and I_P for all ways in which the runs could have been labelled; None for a single run."""
    if min(one.count, other.count) < 2:
        return None, None
    if paired:
        baseline, proposed = swapped(one, other, swaps_of(range(one.count)).signs if signs is None else signs)
    else:
        shares = label_shares(one.count, other.count)
        proposed, baseline = (np.stack(mixtures((one, other), np.maximum(side, 0.0))) for side in (shares, -shares))
    differences = proposed - baseline
    rounding = ROUNDING * (np.abs(proposed) + np.abs(baseline)).sum(axis=0)
    return tuple(np.where(np.abs(differences) <= rounding, 0.0, differences))


class Splitter:
    """Splits the ratio of one amount, an index or a mean return."""

    def __init__(self, name: str, sums: ScoredSums, why_zero: str = "", counterparts: ScoredSums | None = None) -> None:
        """Take what is known.

        Args:
            name: The name of the amount, such as ``I_N``.
            sums: The amount of every group of runs, under every reward that scored it.
            why_zero: What an amount of 0 means; not needed if the amount cannot be 0.
            counterparts: The other index of the same curves, beside which this one may be next to nothing.
        """
        self._name, self._sums, self._why_zero = name, sums, why_zero
        self._seeds = min(map(len, sums.each.values()))
        self._is_scored = {BK, KB} <= sums.whole.keys()
        compared = ((BB, BK), (KB, KK)) if self._is_scored else ((BB, KK),)
        self._near_zero = dict(found for pairs in compared for found in self._small_beside_another(*pairs))
        if counterparts is not None:
            self._near_zero.update(self._small_beside_its_counterpart(counterparts))

    def split(self, outcomes: Float | None, missing: str | None) -> Split:
        """The split without the noise floor."""
        eta, per_seed = self._ratio(KK, BB), self._per_seed()
        p = None if outcomes is None else p_of(outcomes)
        if not self._is_scored:
            nothing = Estimate(None, notes=("not re-scored" if missing is None else missing,))
            return Split(eta, per_seed, nothing, nothing, nothing, p=p, outcomes=outcomes)
        paths = (
            SplitPath(self._of_unlike_seeds(self._ratio(KK, BK)), self._ratio(BK, BB)),
            SplitPath(self._of_unlike_seeds(self._ratio(KB, BB)), self._ratio(KK, KB)),
        )
        ruler = self._of_unlike_seeds(
            self._combined(paths, lambda sums: 0.5 * (_log(sums, KK, BK) + _log(sums, KB, BB)))
        )
        behaviour = self._combined(paths, lambda sums: 0.5 * (_log(sums, BK, BB) + _log(sums, KK, KB)))
        interaction = self._of_unlike_seeds(self._combined(paths, lambda sums: _log(sums, KK, BK) - _log(sums, KB, BB)))
        return Split(eta, per_seed, ruler, behaviour, interaction, paths, p=p, outcomes=outcomes)

    def _ratio(self, numerator: Pair, denominator: Pair) -> Estimate:
        """One ratio with its interval, or with the reason why there is none."""
        owner, divisor = f"{self._name} of {OWNER[denominator]}", self._sums.value(denominator)
        if divisor == 0.0:
            return Estimate(None, notes=(f"{owner} is 0: {self._why_zero}",))
        value = self._sums.value(numerator) / divisor + 0.0  # no -0.0
        if not math.isfinite(value):
            return Estimate(None, notes=(f"{owner} is as good as 0: the ratio is no number any more",))
        near = self._near_zero.get(denominator, self._near_zero.get(numerator))
        return self._with_interval(value, lambda sums: _log(sums, numerator, denominator), near)

    def _combined(self, paths: tuple[SplitPath, ...], logarithm: Callable[[Sums], Float]) -> Estimate:
        """A ratio that combines both paths."""
        parts = [part for path in paths for part in path]
        undefined = next((part for part in parts if part.value is None), None)
        if undefined is not None:
            return Estimate(None, notes=undefined.notes)
        if min(part.value for part in parts if part.value is not None) <= 0.0:
            return Estimate(None, notes=("a part of a path is not above 0: the paths have no geometric mean",))
        near = next((part.near_zero for part in parts if part.near_zero is not None), None)
        return self._with_interval(_exp(logarithm(self._sums.whole)[0]), logarithm, near)

    def _per_seed(self) -> Estimate:
        """The geometric mean of single seeds' etas; for unpaired runs the ratio of their geometric means."""
        each = self._sums.each
        zeros = {pair: int(np.count_nonzero(each[pair] == 0.0)) for pair in (BB, KK)}
        for pair, count in zeros.items():
            if count:
                of = f"{count} of the {len(each[pair])} runs of {OWNER[pair]}"
                return Estimate(None, notes=(f"{self._name} of {of} is 0 by itself",))
        if (np.sign(each[BB][:1]) != np.sign([*each[BB], *each[KK]])).any():
            return Estimate(None, notes=(f"{self._name} of single runs has either sign",))
        whole, left_out = self._sums.geometric()
        knife = jackknife(lambda sums: _log(sums, KK, BB), whole, left_out)
        return self._bounded(_exp(knife.value), knife, None)

    def _of_unlike_seeds(self, ruler: Estimate) -> Estimate:
        """The ruler without its interval if a few seeds make up an index. The interval would miss on one side."""
        if ruler.low is None or not self._seeds_are_unlike:
            return ruler
        reason = f"no interval: single seeds' {self._name} may differ so much that a few of them decide the ruler"
        return replace(ruler, low=None, high=None, notes=(*ruler.notes, reason))

    @cached_property
    def _seeds_are_unlike(self) -> bool:
        with np.errstate(divide="ignore"):
            sizes = [np.log(np.abs(self._sums.each[pair])) for pair in (BB, KK)]
        return not all(np.isfinite(size).all() and _are_alike(size) for size in sizes)

    def _with_interval(self, value: float, logarithm: Callable[[Sums], Float], near: str | None) -> Estimate:
        return self._bounded(value, jackknife(logarithm, self._sums.whole, self._sums.left_out), near)

    def _bounded(self, value: float, knife: Jackknife, near: str | None) -> Estimate:
        """A ratio with the interval of its logarithm."""
        if not math.isfinite(value):
            return Estimate(None, notes=("the ratio is too large for a number",))
        notes = why_no_interval(self._seeds)
        if not notes and value <= 0.0:
            notes = ("no interval: the ratio is not above 0",)
        elif not (notes or knife.is_defined):
            notes = (f"no interval: without one of the seeds {self._name} of a group is 0 or changes its sign",)
        if notes:
            return Estimate(value, None, None, self._seeds, notes, near)
        low, high = map(_exp, knife.interval())
        if not math.isfinite(high):
            notes = ("no interval: its upper end is too large for a number",)
            return Estimate(value, None, None, self._seeds, notes, near)
        return Estimate(value, low, high, self._seeds, near_zero=near)

    def _small_beside_another(self, one: Pair, other: Pair) -> Iterator[tuple[Pair, str]]:
        for small, large in ((one, other), (other, one)):
            if abs(self._sums.value(small)) < NEAR_ZERO * abs(self._sums.value(large)):
                yield small, f"{self._name} of {OWNER[small]} is near zero beside that of {OWNER[large]}"

    def _small_beside_its_counterpart(self, counterparts: ScoredSums) -> Iterator[tuple[Pair, str]]:
        """Whether a curve hardly ever has this sign, so that its few values decide nothing."""
        other = "I_P" if self._name == "I_N" else "I_N"
        for pair in self._sums.whole:
            if abs(self._sums.value(pair)) < NEGLIGIBLE * abs(counterparts.value(pair)):
                yield pair, f"{self._name} of {OWNER[pair]} is near zero beside {other} of the same runs"


def split_sum(sums: ScoredSums, missing: str | None = None) -> SumSplit:
    """The change of an amount from the baseline to the proposed reward, with its parts or why they are `missing`."""
    change = _amount(sums, lambda of: of[KK] - of[BB])
    if not {BK, KB} <= sums.whole.keys():
        nothing = Estimate(None, notes=("not re-scored" if missing is None else missing,))
        return SumSplit(change, nothing, nothing)
    ruler = _amount(sums, lambda of: 0.5 * ((of[KK] - of[BK]) + (of[KB] - of[BB])))
    behaviour = _amount(sums, lambda of: 0.5 * ((of[BK] - of[BB]) + (of[KK] - of[KB])))
    return SumSplit(change, ruler, behaviour)


def _amount(sums: ScoredSums, number: Callable[[Sums], Float]) -> Estimate:
    """A difference with its interval."""
    seeds = min(len(each) for each in sums.each.values())
    value, notes = float(number(sums.whole)[0]), why_no_interval(seeds)
    if notes:
        return Estimate(value, seeds=seeds, notes=notes)
    return Estimate(value, *jackknife(number, sums.whole, sums.left_out).interval(), seeds=seeds)


def _are_alike(logarithms: Float) -> bool:
    """Whether the sizes of single seeds certainly have a small enough spread."""
    _, largest = spread_range(float(np.std(logarithms, ddof=1)), len(logarithms))
    return largest <= UNLIKE


def _exp(logarithm: float) -> float:
    """The exponential; infinite if it is too large for a float."""
    with np.errstate(over="ignore"):
        return float(np.exp(logarithm))


def _log(sums: Sums, numerator: Pair, denominator: Pair) -> Float:
    logarithm: Float = np.log(sums[numerator] / sums[denominator])
    return logarithm


SEED = 105
SPLITS = 200
LEAST_RUNS = 4


def noise_floor(baseline: GroupCurve, control: GroupCurve | None, which: int) -> Estimate:
    """The ratio 1, with the range that holds the share `CONFIDENCE` of the etas that seeds alone make.

    With a control, the baseline trained again with as many other seeds, halves of all runs are as large as the groups
    that are compared. Without one, halves of the baseline's runs are smaller than they and differ more: their
    logarithms are scaled by the root of how much smaller. So few runs know their spread only roughly: the range is as
    much wider as Student's interval is than that of the normal distribution.

    Args:
        baseline: Its runs, scored by their own reward.
        control: The baseline trained again with other seeds; None if it was not.
        which: 0 for I_N, 1 for I_P.
    """
    groups = [baseline] if control is None else [baseline, control]
    count = sum(group.count for group in groups)
    told = "" if control is None else "the baseline trained again with other seeds"
    return _range(count, baseline.count, lambda shares: mixtures(groups, shares)[which], "an index of 0", told)


def noise_of_means(values: Float) -> Estimate:
    """The noise floor of a mean over runs of the baseline, such as a mean return.

    Args:
        values: The value of each run, (runs,).
    """
    return _range(len(values), len(values), lambda shares: shares @ values, "a mean that is not above 0", "")


def _range(count: int, compared: int, of: Callable[[Float], Float], undefined: str, told: str) -> Estimate:
    """The range of the ratio of one half's amount to the other half's.

    Args:
        count: How many runs are halved.
        compared: How many runs each group of the real comparison has.
        of: A function from shares of the runs, (splits, count), to the amount, (splits,).
        undefined: What a half has if its amount has no logarithm.
        told: What was halved; empty for the baseline's own runs.
    """
    if count < LEAST_RUNS:
        return Estimate(None, notes=(f"{count} runs of the baseline: halves of them need at least {LEAST_RUNS}",))
    half = count // 2
    first, second = (of(shares) for shares in split_halves(count))
    tail = (1.0 - CONFIDENCE) / 2.0
    widening = quantile(CONFIDENCE, count - 1) / NormalDist().inv_cdf(1.0 - tail)  # as so few runs know their spread
    with np.errstate(all="ignore"):
        logarithms = np.log(first / second) * math.sqrt(half / compared) * widening
    if not np.isfinite(logarithms).all():
        return Estimate(None, notes=(f"a half of the baseline's runs has {undefined}",))
    low, high = np.exp(np.quantile(logarithms, [tail, 1.0 - tail]))
    return Estimate(1.0, float(low), float(high), count, (told or f"halves of {count} runs, scaled to all",))


def split_halves(count: int, splits: int = SPLITS) -> tuple[Float, Float]:
    """Shares of two disjoint halves of `count` runs, drawn at random, (splits, count) both."""
    rng = np.random.default_rng([SEED, count])
    half = count // 2
    order = rng.permuted(np.tile(np.arange(count), (splits, 1)), axis=1)
    first, second = np.zeros((splits, count)), np.zeros((splits, count))
    np.put_along_axis(first, order[:, :half], 1.0 / half, axis=1)
    np.put_along_axis(second, order[:, half : 2 * half], 1.0 / half, axis=1)
    return first, second
