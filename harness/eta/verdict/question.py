"""A question about a reward: does it make the robot behave better than the baseline, in the places where both trained?

A *place* is where trainings are compared: a simulator, task and algorithm with all their parameters.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from harness.arrays import Float, Ints, Mask
from harness.eta.interval import UNBOUNDED, Interval, Side, difference_bounds, mean_bounds, quantile
from harness.eta.verdict.deals import Strata, as_trained, deals_of

LEAST_SPREAD = 0.001
"""A standard error counts as at least this share of the pooled standard deviation."""
LEAST_SEEDS = 2
"""With fewer trainings of a side in a place there is no spread, and so no test."""
BOTH = (0, 1)
"""The two sides of a question: the baseline, and the proposed reward."""


class Layout(NamedTuple):
    """The trainings of a question in the order in which labels are dealt to them.

    A training keeps all that was measured of it when it changes its label. Labels are dealt among the trainings that
    were done in the same places, with the same measures known. So of each pattern each side has as many in every way,
    and what a training counts under one label never changes.
    """

    strata: Strata
    values: Float
    """(trainings, places, measures), without the mean of their place over both sides; 0 where there is none."""
    weights: tuple[Float, Float]
    """The share of a training in the mean of its place under either label, (trainings, places, measures) both; 0 where
    it has no value, or where no training under that label has one."""
    factors: tuple[Float, Float]
    """n / (n - 1) under either label, (trainings, measures) both, as in an unbiased variance: n trainings with that
    label have a value where this one has one, and of several places the fewest count."""
    least: Float
    """The smallest standard error that counts, of the mean of each place, (places, measures)."""


@dataclass(frozen=True, eq=False)
class Question:
    """What was measured of the trainings of two rewards.

    The trainings of the two sides are not paired: row i of one has nothing to do with row i of the other, and one may
    have more trainings than the other one.

    Attributes:
        values: (2, rows, places, measures): of the baseline and of the proposed reward, higher is better. NaN where a
            row has no training on that side in a place, or where it left no value.
        ends: The least and the greatest value that a measure can have in a place, as `values` count it, (places,
            measures, 2); infinite where none is known.
        begun: Where a row has a training, (2, rows, places); one without a value is counted where it speaks most
            against a word.
    """

    values: Float
    ends: Float
    begun: Mask

    @classmethod
    def of(cls, values: Float, ends: Float | None = None, begun: Mask | None = None) -> "Question":
        """A question about trainings. By default those that left a value were begun, and no end is known."""
        unbounded = np.broadcast_to(UNBOUNDED, (*values.shape[2:], 2))
        there: Mask = np.asarray(np.isfinite(values).any(axis=3))
        return cls(values, unbounded if ends is None else ends, there if begun is None else begun)

    @property
    def places(self) -> int:
        """How many places."""
        return int(self.values.shape[2])

    @cached_property
    def known(self) -> Mask:
        """(2, rows, places, measures): where there is a value."""
        known: Mask = np.isfinite(self.values)
        return known

    @property
    def counts(self) -> tuple[int, int]:
        """The fewest trainings that a measure has in a place, of the baseline and of the proposed reward."""
        if not self.values.size:
            return 0, 0
        baseline, proposed = self.known.sum(axis=1).min(axis=(1, 2))
        return int(baseline), int(proposed)

    @property
    def seeds(self) -> int:
        """The fewest trainings that either side has for a measure in a place."""
        return min(self.counts)

    @property
    def is_testable(self) -> bool:
        """Whether every measure has a spread in every place."""
        return self.seeds >= LEAST_SEEDS

    @cached_property
    def means(self) -> tuple[float, float]:
        """Under the baseline and under the proposed reward, of the first measure: over trainings, then over places."""
        one, other = self._means_of_places[..., 0].mean(axis=1)
        return float(one), float(other)

    @cached_property
    def differences(self) -> Float:
        """Proposed - baseline, means over trainings, (places, measures)."""
        baseline, proposed = self._means_of_places
        differences: Float = proposed - baseline
        return differences

    @cached_property
    def _means_of_places(self) -> Float:
        """Means over trainings, (2, places, measures)."""
        means: Float = np.nanmean(np.where(self.known, self.values, np.nan), axis=1)
        return means

    def in_places(self, at: Ints) -> "Question":
        """The same question about some of its places."""
        return Question(self.values[:, :, at], self.ends[at], self.begun[:, :, at])

    def among(self, there: Mask) -> "Question":
        """The same question about some of its trainings, (rows, places)."""
        values = np.where(there[None, :, :, None], self.values, np.nan)
        return Question(values, self.ends, self.begun & there[None])

    @cached_property
    def has_lost(self) -> bool:
        """Whether a training was begun that has no value of some measure."""
        return bool((self.begun[..., None] & ~self.known).any())

    @property
    def at_worst(self) -> "Question":
        """The same question, with each training that left no value at the end that is worst."""
        lost = self.begun[..., None] & ~self.known
        return replace(self, values=np.where(lost & np.isfinite(self.ends[..., 0]), self.ends[..., 0], self.values))

    def has_ends(self, measure: int) -> bool:
        """Whether it is known in every place how good and how bad a measure can be."""
        return bool(np.isfinite(self.ends[:, measure]).all())

    def bounds(self, measure: int, confidence: float) -> Interval:
        """What proposed - baseline of one measure can be, mean over places: the bound that any word rests on.

        It is that of `harness.eta.interval`. A seed may end alike in several places, so Student's interval over seeds
        counts too.
        """
        both = self._sides[measure]
        is_lost = any(any(side.lost) for side in both)
        if min(len(of) for side in both for of in side.values) < LEAST_SEEDS or (
            is_lost and not self.has_ends(measure)
        ):
            return UNBOUNDED
        low, high = difference_bounds(*both, confidence)
        if self.places == 1:
            return low, high
        difference, error = (float(it[0]) for it in self._mean(measure, as_trained(self.layout.strata)[None, :]))
        reach = quantile(confidence, self._freedom(measure)) * error
        return min(low, difference - reach), max(high, difference + reach)

    def most(self, measure: int) -> tuple[float, float]:
        """What the mean over places of one measure lies below in 95 %, under either reward."""
        one, other = (mean_bounds(side)[1] for side in self._sides[measure])
        return one, other

    @cached_property
    def _sides(self) -> list[tuple[Side, Side]]:
        """What each measure came to under the baseline, and under the proposed reward."""
        return [self._sides_of(measure) for measure in range(self.values.shape[3])]

    def _sides_of(self, measure: int) -> tuple[Side, Side]:
        known, values = self.known[..., measure], self.values[..., measure]
        ends = [(float(low), float(high)) for low, high in self.ends[:, measure]]
        lost = (self.begun & ~known).sum(axis=1).tolist()
        one, other = (
            Side([side[there[:, at], at] for at in range(self.places)], ends, of)
            for side, there, of in zip(values, known, lost, strict=True)
        )
        return one, other

    def leaning(self, measure: int, confidence: float) -> int:
        """1 where the bound of a measure lies above 0, -1 where below; 0 where it holds 0 or an end is not known."""
        low, high = self.bounds(measure, confidence) if self.has_ends(measure) else UNBOUNDED
        return int(low > 0.0) - int(high < 0.0)

    @cached_property
    def layout(self) -> Layout:
        """See `Layout`."""
        strata, sides, rows = _strata_of(self.known)
        counts = self.known.sum(axis=1)
        known, values = self.known[sides, rows], self.values[sides, rows]
        values = np.where(known, values, np.nan)
        values = np.nan_to_num(values - np.nanmean(values, axis=0))
        weights = [np.where(known, 1.0 / np.maximum(count, 1), 0.0) for count in counts]
        fewest = [np.where(known, count, count.max()).min(axis=1) for count in counts]
        factors = [count / np.maximum(count - 1.0, 1.0) for count in fewest]
        spread = np.sqrt((values**2).sum(axis=0) / np.maximum(counts.sum(axis=0) - 1, 1))
        return Layout(strata, values, (weights[0], weights[1]), (factors[0], factors[1]), LEAST_SPREAD * spread)

    @cached_property
    def deals(self) -> Float:
        """The ways in which labels are dealt, (ways, trainings); see `deals_of`."""
        return deals_of(self.layout.strata)

    def statistics(self) -> Float:
        """Welch's t of the mean over all places, in every way to deal the labels, (ways, measures)."""
        of_measures = (self._mean(measure, self.deals) for measure in range(self.values.shape[3]))
        return np.stack([_ratio(*it) for it in of_measures], axis=1)

    def error(self, measure: int) -> float:
        """The standard error of the difference of a measure, mean over all places."""
        return float(self._mean(measure, as_trained(self.layout.strata)[None, :])[1][0])

    def _freedom(self, measure: int) -> float:
        """Degrees of freedom after Welch and Satterthwaite: a side's trainings in the same places are a group."""
        total, squares = 0.0, 0.0
        for side in BOTH:
            known = self.known[side, :, :, measure]
            values = np.where(known, self.values[side, ..., measure], 0.0) / np.maximum(known.sum(axis=0), 1)
            for pattern in np.unique(known[known.any(axis=1)], axis=0):
                group = values[(known == pattern).all(axis=1)].sum(axis=1)
                if len(group) < LEAST_SEEDS:
                    continue
                part = len(group) * group.var(ddof=1)
                total, squares = total + part, squares + part**2 / (len(group) - 1)
        return float(total**2 / squares) if squares > 0.0 else float(self.seeds - 1)

    def _mean(self, measure: int, deals: Float) -> tuple[Float, Float]:
        """The difference of one measure, mean over all places, and its standard error, (ways,) both."""
        layout, places = self.layout, self.places
        variance, of_sides = np.zeros(len(deals)), []
        for side in BOTH:
            weights, factors = layout.weights[side][:, :, measure], layout.factors[side][:, measure]
            weighted = weights * layout.values[:, :, measure]
            shares = weighted.sum(axis=1) / places
            sums = (factors * shares)[:, None] * np.column_stack([shares, weights])
            both = _products_of(side, layout.strata, weights * factors[:, None], weights) / places**2
            means, dealt = _of_side(side, deals, weighted), _of_side(side, deals, sums)
            variance = variance + dealt[:, 0] - 2.0 * (means * dealt[:, 1:]).sum(axis=1) / places
            variance = variance + np.einsum("wp,pq,wq->w", means, both, means, optimize=True)
            of_sides.append(means)
        ours, theirs = of_sides
        least = float(np.sqrt((layout.least[:, measure] ** 2).sum())) / places
        return (theirs - ours).mean(axis=1), _error(variance, least)


def _strata_of(known: Mask) -> tuple[Strata, Ints, Ints]:
    """The strata, and of each training, in the order of the labels, its side and its row.

    A row without a value on a side is no training of it.
    """
    found: dict[tuple[int, ...], tuple[list[int], list[int]]] = {}
    for side, row in np.argwhere(known.any(axis=(2, 3))):
        found.setdefault(tuple(map(int, known[side, row].ravel())), ([], []))[side].append(int(row))
    order = sorted(found)
    strata = tuple((name, len(found[key][0]), len(found[key][1])) for name, key in enumerate(order))
    rows = [row for key in order for of_side in found[key] for row in of_side]
    return strata, as_trained(strata).astype(np.int64), np.array(rows, np.int64)


def _of_side(side: int, deals: Float, columns: Float) -> Float:
    """Sums of columns over the trainings that carry a side's label, in each way."""
    proposed: Float = deals @ columns
    return proposed if side else columns.sum(axis=0) - proposed


def _products_of(side: int, strata: Strata, one: Float, other: Float) -> Float:
    """Sums of products over the trainings of a side, (columns, columns).

    They are the same in every way, for of each pattern a side has as many in every way.
    """
    labelled = as_trained(strata) == side
    products: Float = one[labelled].T @ other[labelled]
    return products


def _error(variance: Float, least: Float | float) -> Float:
    """The standard error of a variance, rounding errors aside."""
    error: Float = np.maximum(np.sqrt(np.maximum(variance, 0.0)), least)
    return error


def _ratio(difference: Float, error: Float) -> Float:
    """A difference in standard errors; 0 where nothing varies."""
    ratio: Float = np.divide(difference, error, out=np.zeros_like(difference), where=error > 0.0)
    return ratio
