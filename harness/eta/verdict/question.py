"""A question about a reward: does it make the robot behave better than the baseline, in the places where both trained?

A *place* is where trainings are compared: a simulator, task and algorithm with all their parameters.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from harness.arrays import Float, Ints, Mask
from harness.eta.verdict.deals import MOST_DEALS, Strata, deals_of

LEAST_SPREAD = 0.001
"""A standard error counts as at least this share of the pooled standard deviation."""
LEAST_SEEDS = 2
"""With fewer seeds in a place there is no spread, and so no test."""
CHUNK = MOST_DEALS // 8
"""Ways whose covariances of places are in memory at once."""


class Layout(NamedTuple):
    """The trainings of a question in the order in which labels are dealt to them.

    Whole seeds change their label, among the seeds that were trained in the same places at the same looks.
    """

    strata: Strata
    values: Float
    """(trainings, places, measures), without the mean of their place; 0 where there is none."""
    weights: Float
    """The share of a training in the mean of its place, (trainings, places, measures); 0 where it has no value."""
    factors: Float
    """n / (n - 1) of the n seeds that a training is one of, (trainings, measures), as in an unbiased variance."""
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

    Attributes:
        values: (2, seeds, places, measures): of the baseline and of the proposed reward, higher is better. NaN where a
            seed was not trained, or not measured, under one of them in a place.
        looks: The look at which a seed was trained in each place, (seeds, places); 0 if all were trained at once.
        is_drawn: Whether labels are dealt in drawn ways even where all could be tried, as tests in several looks are.
    """

    values: Float
    looks: Ints
    is_drawn: bool = False

    @classmethod
    def of(cls, values: Float) -> "Question":
        """A question about trainings that were done at once, see `values`."""
        return cls(values, np.zeros(values.shape[1:3], np.int64))

    @property
    def places(self) -> int:
        """How many places."""
        return int(self.values.shape[2])

    @cached_property
    def known(self) -> Mask:
        """(seeds, places, measures): where there is a value under both rewards."""
        known: Mask = np.isfinite(self.values[0]) & np.isfinite(self.values[1])
        return known

    @property
    def seeds(self) -> int:
        """The fewest seeds that a measure has in a place."""
        return int(self.known.sum(axis=0).min()) if self.values.size else 0

    @property
    def is_testable(self) -> bool:
        """Whether every measure has a spread in every place."""
        return self.seeds >= LEAST_SEEDS

    @cached_property
    def means(self) -> tuple[float, float]:
        """Under the baseline and under the proposed reward, of the first measure: over seeds, then over places."""
        values = np.where(self.known, self.values, np.nan)[..., 0]
        one, other = np.nanmean(values, axis=1).mean(axis=1)
        return float(one), float(other)

    @cached_property
    def differences(self) -> Float:
        """Proposed - baseline, means over seeds, (places, measures)."""
        values = np.where(self.known, self.values, np.nan)
        differences: Float = np.nanmean(values[1] - values[0], axis=0)
        return differences

    def in_place(self, place: int) -> "Question":
        """The same question about one place."""
        there = self.known[:, place].any(axis=1)
        return Question(self.values[:, there, place : place + 1], self.looks[there, place : place + 1], self.is_drawn)

    def until(self, look: int) -> "Question":
        """The same question as it stood at a look."""
        values = np.where((self.looks <= look)[None, :, :, None], self.values, np.nan)
        there = np.isfinite(values).any(axis=(0, 2, 3))
        return Question(values[:, there], self.looks[there], self.is_drawn)

    @cached_property
    def layout(self) -> Layout:
        """See `Layout`."""
        strata, order = _strata_of(self.known, self.looks)
        count = self.known.sum(axis=0)
        known = np.concatenate([np.tile(self.known[seeds], (2, 1, 1)) for seeds in order])
        values = np.concatenate([self.values[:, seeds].reshape(-1, *self.values.shape[2:]) for seeds in order])
        values = np.where(known, values, np.nan)
        values = np.nan_to_num(values - np.nanmean(values, axis=0))
        weights = known / count
        fewest = np.where(known, count, count.max()).min(axis=1)
        spread = np.sqrt((values**2).sum(axis=0) / np.maximum(2 * count - 1, 1))
        return Layout(strata, values, weights, fewest / np.maximum(fewest - 1.0, 1.0), LEAST_SPREAD * spread)

    @cached_property
    def deals(self) -> Float:
        """The ways in which labels are dealt, (ways, trainings); see `deals_of`."""
        return deals_of(self.layout.strata, self.is_drawn)

    def statistics(self, deals: Float | None = None) -> Float:
        """Welch's t of the mean over all places, in every way to deal the labels, (ways, measures).

        Args:
            deals: Other ways, (ways, trainings); by default `deals`.
        """
        deals = self.deals if deals is None else deals
        return np.stack([_ratio(*self._mean(measure, deals)) for measure in range(self.values.shape[3])], axis=1)

    def estimate(self, measure: int = 0) -> Estimate:
        """The difference of one measure, mean over all places, and how far it can be trusted."""
        trained = self.layout.strata
        as_trained = np.concatenate([np.repeat([0.0, 1.0], seeds) for _, seeds in trained])[None, :]
        difference, error = self._mean(measure, as_trained)
        return Estimate(float(difference[0]), float(error[0]), self._freedom(measure))

    def _freedom(self, measure: int) -> float:
        """Degrees of freedom after Welch and Satterthwaite: seeds that were trained in the same places are a group."""
        groups: dict[bytes, list[int]] = {}
        for seed, known in enumerate(self.known[:, :, measure]):
            groups.setdefault(known.tobytes(), []).append(seed)
        weights = self.known[:, :, measure] / self.known[:, :, measure].sum(axis=0)
        total, squares = 0.0, 0.0
        for seeds in groups.values():
            if len(seeds) < LEAST_SEEDS:
                continue
            values = np.nan_to_num(self.values[..., measure][:, seeds]) * weights[seeds]
            parts = len(seeds) * values.sum(axis=2).var(axis=1, ddof=1)
            total, squares = total + parts.sum(), squares + (parts**2).sum() / (len(seeds) - 1)
        return float(total**2 / squares) if squares > 0.0 else float(self.seeds - 1)

    def _mean(self, measure: int, deals: Float) -> tuple[Float, Float]:
        """The difference of one measure, mean over all places, and its standard error, (ways,) both."""
        layout, places = self.layout, self.places
        weights, factors = layout.weights[:, :, measure], layout.factors[:, measure]
        weighted = weights * layout.values[:, :, measure]
        shares = weighted.sum(axis=1) / places
        sums = (factors * shares)[:, None] * np.column_stack([shares, weights])
        both = _twice(weights * factors[:, None], weights) / places**2
        variance, sides = np.zeros(len(deals)), _of_both(deals, weighted)
        for means, dealt in zip(sides, _of_both(deals, sums), strict=True):
            variance = variance + dealt[:, 0] - 2.0 * (means * dealt[:, 1:]).sum(axis=1) / places
            variance = variance + np.einsum("wp,pq,wq->w", means, both, means, optimize=True)
        ours, theirs = sides
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
        weights, factors = layout.weights[:, :, measure], layout.factors[:, measure, None]
        weighted = weights * layout.values[:, :, measure]
        both = _twice(weights * factors, weights)
        covariance, sides = np.zeros((len(deals), places, places)), _of_both(deals, weighted)
        for means, squares, mixed in zip(
            sides,
            _of_both(deals, _products(weighted * factors, weighted)),
            _of_both(deals, _products(weighted * factors, weights)),
            strict=True,
        ):
            crossed = mixed.reshape(-1, places, places) * means[:, None, :]
            covariance += squares.reshape(-1, places, places) - crossed - crossed.transpose(0, 2, 1)
            covariance += both * means[:, :, None] * means[:, None, :]
        ours, theirs = sides
        sizes = subsets.sum(axis=1)
        pairs = _products(subsets, subsets)
        variance = covariance.reshape(len(deals), -1) @ pairs.T / sizes**2
        least = np.sqrt(subsets @ layout.least[:, measure] ** 2) / sizes
        return _ratio((theirs - ours) @ subsets.T / sizes, _error(variance, least))


def _strata_of(known: Mask, looks: Ints) -> tuple[Strata, list[list[int]]]:
    """The strata, and the seeds in each; those of later looks stand behind those of earlier ones.

    A seed without a value is in none.
    """
    found: dict[tuple[tuple[int, ...], ...], list[int]] = {}
    for seed, (there, at) in enumerate(zip(known, looks, strict=True)):
        if not there.any():
            continue
        seen = tuple(int(look) if any_known else -1 for look, any_known in zip(at, there.any(axis=1), strict=True))
        found.setdefault(((max(seen),), seen, tuple(map(int, there.ravel()))), []).append(seed)
    order = sorted(found)
    first = [key[0][0] for key in order]
    names = [look * 1000 + first[:at].count(look) for at, look in enumerate(first)]
    seeds = [found[key] for key in order]
    return tuple(zip(names, map(len, seeds), strict=True)), seeds


def _of_both(deals: Float, columns: Float) -> tuple[Float, Float]:
    """Sums of columns over the baseline's trainings, and over the proposed reward's, in each way."""
    proposed: Float = deals @ columns
    return columns.sum(axis=0) - proposed, proposed


def _products(one: Float, other: Float) -> Float:
    """The products of every two columns, (rows, columns * columns)."""
    products: Float = (one[:, :, None] * other[:, None, :]).reshape(len(one), -1)
    return products


def _twice(one: Float, other: Float) -> Float:
    """Sums of products over one side's trainings, which are the same in every way: strata have as many of each."""
    halves: Float = one.T @ other / 2.0
    return halves


def _error(variance: Float, least: Float | float) -> Float:
    """The standard error of a variance, rounding errors aside."""
    error: Float = np.maximum(np.sqrt(np.maximum(variance, 0.0)), least)
    return error


def _ratio(difference: Float, error: Float) -> Float:
    """A difference in standard errors; 0 where nothing varies."""
    ratio: Float = np.divide(difference, error, out=np.zeros_like(difference), where=error > 0.0)
    return ratio
