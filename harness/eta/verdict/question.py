"""A question about a reward: does it make the robot behave better than the baseline, in the places where both trained?

A *place* is where trainings are compared: a simulator, task and algorithm with all their parameters.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from harness.arrays import Float, Ints, Mask
from harness.eta.interval import UNBOUNDED, Bounds
from harness.eta.verdict.deals import MOST_DEALS, Strata, as_trained, deals_of

LEAST_SPREAD = 0.001
"""A standard error counts as at least this share of the pooled standard deviation."""
LEAST_SEEDS = 2
"""With fewer trainings of a side in a place there is no spread, and so no test."""
CHUNK = MOST_DEALS // 8
"""Ways whose covariances of places are in memory at once."""


BOTH = (0, 1)
"""The two sides of a question: the baseline, and the proposed reward."""


class Layout(NamedTuple):
    """The trainings of a question in the order in which labels are dealt to them.

    A training keeps all that was measured of it when it changes its label. Labels are dealt among the trainings that
    were done in the same places at the same looks, with the same measures known. So of each pattern each side has as
    many in every way, and what a training counts under one label never changes.
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


class Estimate(NamedTuple):
    """A difference of means over places."""

    difference: float
    error: float
    """Its standard error."""
    freedom: float
    """The degrees of freedom of Student's t for it."""


@dataclass(frozen=True, eq=False)
class Question:
    """What was measured of the trainings of two rewards.

    The trainings of the two sides are not paired: row i of one has nothing to do with row i of the other, and one may
    have more trainings than the other one.

    Attributes:
        values: (2, rows, places, measures): of the baseline and of the proposed reward, higher is better. NaN where a
            row has no training on that side in a place, or where it was not measured.
        looks: The look at which a row was trained in each place, (rows, places); 0 if all were trained at once.
        ends: The least and the greatest value that a measure can have in a place, as `values` count it, (places,
            measures, 2); infinite where none is known.
        is_drawn: Whether labels are dealt in drawn ways even where all could be tried, as tests in several looks are.
    """

    values: Float
    looks: Ints
    ends: Float
    is_drawn: bool = False

    @classmethod
    def of(cls, values: Float, ends: Float | None = None, looks: Ints | None = None) -> "Question":
        """A question about trainings. By default they were done at once, and no end is known."""
        at_once = np.zeros(values.shape[1:3], np.int64)
        unbounded = np.broadcast_to(UNBOUNDED, (*values.shape[2:], 2))
        return cls(values, at_once if looks is None else looks, unbounded if ends is None else ends)

    @property
    def first_ends(self) -> list[Bounds]:
        """What a value of the first measure can be, by place."""
        return [(float(low), float(high)) for low, high in self.ends[:, 0]]

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
        there = self.known[:, :, at].any(axis=(0, 2, 3))
        return Question(self.values[:, there][:, :, at], self.looks[there][:, at], self.ends[at], self.is_drawn)

    def until(self, look: int) -> "Question":
        """The same question as it stood at a look."""
        values = np.where((self.looks <= look)[None, :, :, None], self.values, np.nan)
        there = np.isfinite(values).any(axis=(0, 2, 3))
        return Question(values[:, there], self.looks[there], self.ends, self.is_drawn)

    @cached_property
    def layout(self) -> Layout:
        """See `Layout`."""
        strata, sides, rows = _strata_of(self.known, self.looks)
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
        return deals_of(self.layout.strata, self.is_drawn)

    def statistics(self) -> Float:
        """Welch's t of the mean over all places, in every way to deal the labels, (ways, measures)."""
        of_measures = (self._mean(measure, self.deals) for measure in range(self.values.shape[3]))
        return np.stack([_ratio(*it) for it in of_measures], axis=1)

    @cached_property
    def estimate(self) -> Estimate:
        """The difference of the first measure, mean over all places, and how far it can be trusted."""
        difference, error = self._mean(0, as_trained(self.layout.strata)[None, :])
        return Estimate(float(difference[0]), float(error[0]), self._freedom)

    @property
    def _freedom(self) -> float:
        """Degrees of freedom after Welch and Satterthwaite: a side's trainings in the same places are a group."""
        total, squares = 0.0, 0.0
        for side in BOTH:
            known = self.known[side, :, :, 0]
            values = np.where(known, self.values[side, ..., 0], 0.0) / np.maximum(known.sum(axis=0), 1)
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

    def subset_statistics(self, subsets: Float) -> Iterator[Float]:
        """Welch's t of the mean over each of some sets of places, (ways, subsets, measures), some ways at a time.

        Args:
            subsets: 1 where a place belongs to a set, else 0, (subsets, places).
        """
        for begin in range(0, len(self.deals), CHUNK):
            deals = self.deals[begin : begin + CHUNK]
            of = [self._subset_t(measure, deals, subsets) for measure in range(self.values.shape[3])]
            yield np.stack(of, axis=2)

    def _subset_t(self, measure: int, deals: Float, subsets: Float) -> Float:
        layout, places = self.layout, self.places
        covariance, of_sides = np.zeros((len(deals), places, places)), []
        for side in BOTH:
            weights, factors = layout.weights[side][:, :, measure], layout.factors[side][:, measure, None]
            weighted = weights * layout.values[:, :, measure]
            both = _products_of(side, layout.strata, weights * factors, weights)
            means = _of_side(side, deals, weighted)
            squares = _of_side(side, deals, _products(weighted * factors, weighted))
            mixed = _of_side(side, deals, _products(weighted * factors, weights))
            crossed = mixed.reshape(-1, places, places) * means[:, None, :]
            covariance += squares.reshape(-1, places, places) - crossed - crossed.transpose(0, 2, 1)
            covariance += both * means[:, :, None] * means[:, None, :]
            of_sides.append(means)
        ours, theirs = of_sides
        sizes = subsets.sum(axis=1)
        pairs = _products(subsets, subsets)
        variance = covariance.reshape(len(deals), -1) @ pairs.T / sizes**2
        least = np.sqrt(subsets @ layout.least[:, measure] ** 2) / sizes
        return _ratio((theirs - ours) @ subsets.T / sizes, _error(variance, least))


def _strata_of(known: Mask, looks: Ints) -> tuple[Strata, Ints, Ints]:
    """The strata, and of each training, in the order of the labels, its side and its row.

    Those of later looks stand behind those of earlier ones. A row without a value on a side is no training of it.
    """
    found: dict[tuple[tuple[int, ...], ...], tuple[list[int], list[int]]] = {}
    for side, row in np.argwhere(known.any(axis=(2, 3))):
        there, at = known[side, row], looks[row]
        seen = tuple(int(look) if any_known else -1 for look, any_known in zip(at, there.any(axis=1), strict=True))
        key = ((max(seen),), seen, tuple(map(int, there.ravel())))
        found.setdefault(key, ([], []))[side].append(int(row))
    order = sorted(found)
    first = [key[0][0] for key in order]
    names = [look * 1000 + first[:at].count(look) for at, look in enumerate(first)]
    strata = tuple((name, len(found[key][0]), len(found[key][1])) for name, key in zip(names, order, strict=True))
    rows = [row for key in order for of_side in found[key] for row in of_side]
    return strata, as_trained(strata).astype(np.int64), np.array(rows, np.int64)


def _of_side(side: int, deals: Float, columns: Float) -> Float:
    """Sums of columns over the trainings that carry a side's label, in each way."""
    proposed: Float = deals @ columns
    return proposed if side else columns.sum(axis=0) - proposed


def _products(one: Float, other: Float) -> Float:
    """The products of every two columns, (rows, columns * columns)."""
    products: Float = (one[:, :, None] * other[:, None, :]).reshape(len(one), -1)
    return products


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
