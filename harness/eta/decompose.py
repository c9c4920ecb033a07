"""How much of eta is only a change of ruler, and how much is behaviour.

With S_r(tau_q) the index of the runs trained under reward q and scored by reward r (B baseline, K proposed)::

    eta = S_K(tau_K) / S_B(tau_B)
        = [S_K(tau_K) / S_B(tau_K)] x [S_B(tau_K) / S_B(tau_B)]        ruler x behaviour
        = [S_K(tau_B) / S_B(tau_B)] x [S_K(tau_K) / S_K(tau_B)]        the other path: ruler x behaviour
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from harness.arrays import Float
from harness.eta.curve import GroupCurve
from harness.eta.index import Index, Ratio
from harness.eta.statistics import (
    draw_shares,
    interval_notes,
    p_value,
    percentile_interval,
    seeds_to_decide,
    split_halves,
)

Who: TypeAlias = Literal["baseline", "proposed"]
Pair: TypeAlias = tuple[Who, Who]
"""Whose reward scores, and whose runs are scored: S_r(tau_q) is (r, q)."""

BB: Pair = ("baseline", "baseline")
KK: Pair = ("proposed", "proposed")
BK: Pair = ("baseline", "proposed")
KB: Pair = ("proposed", "baseline")

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
"""Why an index is 0."""
NEAR_ZERO = 0.01
"""An index below this share of the other training's under the same reward is as good as 0: a ratio with it says little.
Under another reward it may be small because the ruler is."""
NEGLIGIBLE = 1e-4
"""So is an index below this share of the other index of its curve: published curves have an I_N of 0.003 of I_P."""

DISAGREEMENT = 1.5
"""The two paths disagree where their rulers differ by more than this factor."""


class Split(NamedTuple):
    """One index's eta along both paths."""

    eta: Ratio
    ruler: Ratio
    behaviour: Ratio
    other_ruler: Ratio
    other_behaviour: Ratio
    is_scored: bool
    """Whether each training was scored by the other's reward: without that there is nothing but the eta."""
    noise: Ratio
    """What halves of the baseline's own seeds give against each other; 1 with its A/A interval."""
    p: float | None
    """That eta is 1; before correction for several comparisons."""
    seeds_needed: int | None
    """How many seeds would show that eta is not 1."""

    @property
    def is_complete(self) -> bool:
        """Whether all parts of both paths have a value."""
        return None not in (part.value for part in self[1:5])

    @property
    def paths_disagree(self) -> bool:
        """Whether the two paths of scored runs cannot be put together."""
        first, second = self.ruler.value, self.other_ruler.value
        if not self.is_complete or first is None or second is None:
            return self.is_scored
        return min(first, second) <= 0.0 or max(first, second) > DISAGREEMENT * min(first, second)

    @property
    def disagreement(self) -> str:
        """Why they cannot; empty where they can."""
        if not self.paths_disagree:
            return ""
        if not self.is_complete:
            return "a path has no value"
        return (
            f"the two paths disagree: ruler {self.ruler.value:.3g} and behaviour {self.behaviour.value:.3g} on the "
            f"proposed runs, ruler {self.other_ruler.value:.3g} and behaviour {self.other_behaviour.value:.3g} on the "
            "baseline's"
        )


Splits: TypeAlias = Mapping[str, Split]
"""By ``eta_N`` and ``eta_P``."""


@dataclass(frozen=True)
class Decomposition:
    """Both etas, both paths.

    Attributes:
        baseline: Index of the baseline's runs under the baseline.
        proposed: Index of the proposed reward's runs under it.
        negative: The split of eta_N.
        positive: The split of eta_P.
    """

    baseline: Index
    proposed: Index
    negative: Split
    positive: Split

    @property
    def eta_n(self) -> Ratio:
        """NOTE eq. 43; below 1 is called better."""
        return self.negative.eta

    @property
    def eta_p(self) -> Ratio:
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

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        indices = {"baseline": self.baseline.to_json(), "proposed": self.proposed.to_json()}
        return indices | splits_to_json(self.splits)


def no_splits(reason: str) -> Splits:
    """Where there is nothing to compare."""
    nothing = Ratio(None, notes=(reason,))
    empty = Split(nothing, nothing, nothing, nothing, nothing, False, nothing, None, None)
    return {"eta_N": empty, "eta_P": empty}


def splits_to_json(given: Splits) -> dict[str, Any]:
    """Plain data of eta_N's split and eta_P's."""
    splits = {"n": given["eta_N"], "p": given["eta_P"]}
    data: dict[str, Any] = {
        f"{name}_{letter}": getattr(split, name).to_json()
        for letter, split in splits.items()
        for name in ("eta", "ruler", "behaviour")
    }
    data["other_path"] = {
        f"{name}_{letter}": getattr(split, f"other_{name}").to_json()
        for letter, split in splits.items()
        for name in ("ruler", "behaviour")
    }
    for letter, split in splits.items():
        data[f"noise_{letter}"] = split.noise.to_json()
        data[f"paths_disagree_{letter}"] = split.disagreement
        data[f"p_{letter}"] = split.p
        data[f"seeds_needed_{letter}"] = split.seeds_needed
    return data


class _Sums(NamedTuple):
    """One index of one scored group, and its resamples."""

    value: float
    draws: Float


def decompose(curves: Mapping[Pair, GroupCurve], paired: bool = True, missing: str | None = None) -> Decomposition:
    """Both etas with intervals, and how they split.

    Args:
        curves: S_r(tau_q) by (r, q); at least (baseline, baseline) and (proposed, proposed). With the other two the
            etas are split; runs of one training have the same order under both scorings.
        paired: Run i of both trainings has the same seed.
        missing: Why the other two are not there; None where they are, or nobody asked.
    """
    paired = paired and curves[BB].count == curves[KK].count
    streams = {"baseline": 0, "proposed": 0 if paired else 1}
    negative: dict[Pair, _Sums] = {}
    positive: dict[Pair, _Sums] = {}
    for pair, curve in curves.items():
        draws = curve.resample(draw_shares(curve.count, streams[pair[1]]))
        negative[pair] = _Sums(curve.index.negative_sum, draws[0])
        positive[pair] = _Sums(curve.index.positive_sum, draws[1])
    return Decomposition(
        curves[BB].index,
        curves[KK].index,
        _Splitter("I_N", negative, positive, curves).split(_noise(curves[BB], 0), missing),
        _Splitter("I_P", positive, negative, curves).split(_noise(curves[BB], 1), missing),
    )


class _Splitter:
    """Splits one index's eta."""

    def __init__(
        self,
        name: str,
        sums: Mapping[Pair, _Sums],
        counterparts: Mapping[Pair, _Sums],
        curves: Mapping[Pair, GroupCurve],
    ) -> None:
        self._name, self._sums, self._counterparts = name, sums, counterparts
        self._seeds = min(curve.count for curve in curves.values())
        self._why_zero = ZERO[curves[BB].kind, name]
        self._is_scored = BK in sums and KB in sums
        compared = ((BB, BK), (KB, KK)) if self._is_scored else ((BB, KK),)
        self._near_zero = dict(found for pairs in compared for found in self._small_beside_another(*pairs))
        self._near_zero.update(self._small_beside_its_counterpart())

    def split(self, noise: Ratio, missing: str | None) -> Split:
        """See `decompose`."""
        eta = self._ratio(KK, BB)
        p, needed = self._decision(eta)
        if not self._is_scored:
            nothing = Ratio(None, notes=("not re-scored" if missing is None else missing,))
            return Split(eta, nothing, nothing, nothing, nothing, False, noise, p, needed)
        parts = (self._ratio(KK, BK), self._ratio(BK, BB), self._ratio(KB, BB), self._ratio(KK, KB))
        return Split(eta, *parts, True, noise, p, needed)

    def _ratio(self, numerator: Pair, denominator: Pair) -> Ratio:
        """One ratio with its interval, or with the reason why there is none."""
        owner, divisor = f"{self._name} of {OWNER[denominator]}", self._sums[denominator].value
        if divisor == 0.0:
            return Ratio(None, notes=(f"{owner} is 0: {self._why_zero}",))
        value = self._sums[numerator].value / divisor + 0.0  # no -0.0
        if not math.isfinite(value):
            return Ratio(None, notes=(f"{owner} is as good as 0: the ratio is no number any more",))
        near = self._near_zero.get(denominator, self._near_zero.get(numerator))
        if self._seeds < 2:
            return Ratio(value, notes=interval_notes(self._seeds), near_zero=near)
        draws = _divide(self._sums[numerator].draws, self._sums[denominator].draws)
        undefined = np.count_nonzero(~np.isfinite(draws))
        if undefined:
            of = f"in {undefined:,} of {len(draws):,} resamples"
            return Ratio(value, notes=(f"no interval: {owner} is 0 {of}",), near_zero=near)
        return Ratio(value, *percentile_interval(draws), interval_notes(self._seeds), near)

    def _small_beside_another(self, one: Pair, other: Pair) -> Iterator[tuple[Pair, str]]:
        for small, large in ((one, other), (other, one)):
            if abs(self._sums[small].value) < NEAR_ZERO * abs(self._sums[large].value):
                yield small, f"{self._name} of {OWNER[small]} is near zero beside that of {OWNER[large]}"

    def _small_beside_its_counterpart(self) -> Iterator[tuple[Pair, str]]:
        """A curve that is hardly ever of this sign: its few values decide nothing."""
        other = "I_P" if self._name == "I_N" else "I_N"
        for pair, sums in self._sums.items():
            if abs(sums.value) < NEGLIGIBLE * abs(self._counterparts[pair].value):
                yield pair, f"{self._name} of {OWNER[pair]} is near zero beside {other} of the same runs"

    def _decision(self, eta: Ratio) -> tuple[float | None, int | None]:
        if eta.value is None or eta.low is None:
            return None, None
        draws = self._sums[KK].draws / self._sums[BB].draws
        return p_value(draws, 1.0), seeds_to_decide(draws, eta.value, self._seeds)


def _divide(numerator: Float, denominator: Float) -> Float:
    """Element by element; not finite where the denominator is 0, or as good as."""
    with np.errstate(all="ignore"):
        ratio: Float = numerator / denominator + 0.0
    return ratio


def _noise(curve: GroupCurve, which: int) -> Ratio:
    """What eta would be between halves of one group's own seeds: the noise floor."""
    if curve.count < 4:
        return Ratio(None, notes=(f"{curve.count} seeds: halves of them need at least 4",))
    first, second = split_halves(curve.count)
    a, b = curve.resample(first)[which], curve.resample(second)[which]
    ratios = _divide(a, b)
    if not np.isfinite(ratios).all():
        return Ratio(None, notes=("a half of the baseline's seeds has an index of 0",))
    return Ratio(1.0, *percentile_interval(ratios), (f"halves of {curve.count} seeds against each other",))
