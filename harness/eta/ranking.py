"""Rewards in several places: do they keep their order, and would one have chosen another?

All of it rests on intervals of the difference of any two rewards in any place (`harness.eta.interval`). They are so
wide that all of them together hold the true differences in 95 % of the experiments (Bonferroni). Where such an interval
lies on one side of 0, the order of the two rewards is told. What is not told may be either way: an interval of
Kendall's tau spans all orders that are left. ``docs/statistics-tables.md`` shows by simulation why rank correlations
are not resampled.

Which reward may be the best one asks less: a false word has to be about the truly best one (Hsu 1984, multiple
comparisons with the best). It is one of r - 1 bounds in each place, in one direction, in place of r (r - 1) in two.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import combinations, product
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.eta.headline import SUCCESS_MARGIN
from harness.eta.index import Estimate
from harness.eta.interval import (
    CONFIDENCE,
    SHARE,
    UNBOUNDED,
    Side,
    cut_to,
    difference_bounds,
    of_difference,
    why_no_interval,
)
from harness.files.plain import Plain

FEWEST_RANKED = 2
"""The fewest rewards whose orders can be compared, and the fewest places."""
NO_INTERVAL, OPEN = ("no interval: too few seeds in a place",), ("the seeds leave every order open",)

Runs: TypeAlias = Mapping[str, Sequence[float]]
"""The value of each seed, by reward. Every reward has the same seeds in the same order."""
Signs: TypeAlias = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Order:
    """The order of rewards in one place. A larger value is better.

    Attributes:
        rewards: The labels of the rewards.
        means: Means over the seeds, (rewards,).
        low: Lower ends of the intervals of one reward's mean minus another's, (rewards, rewards); -inf where the seeds
            are too few. The upper ends are ``-low.T``.
        low_of_best: Lower bounds of the same. Those of the truly best rewards of all places hold together.
        seeds: How many each mean is over.
    """

    rewards: tuple[str, ...]
    means: Float
    low: Float
    low_of_best: Float
    seeds: int

    @property
    def signs(self) -> Signs:
        """1 if the reward of a row is better than that of a column, -1 if it is worse, 0 if neither is certain.

        The shape is (rewards, rewards). A reward that is better than a better one is better.
        """
        better = self.low > 0.0
        for middle in range(len(better)):
            better = better | (better[:, middle, None] & better[None, middle, :])
        return np.subtract(better, better.T, dtype=np.int64)

    @property
    def best(self) -> int:
        """The reward with the largest mean; the first if several are equal."""
        return int(np.argmax(self.means))

    @property
    def candidates(self) -> tuple[int, ...]:
        """Rewards that may be the best one, because no other is certainly better."""
        return tuple(np.flatnonzero((self.low_of_best <= 0.0).all(axis=0)).tolist())


class Answer(StrEnum):
    """Whether one would have chosen another reward."""

    YES = "yes"
    NO = "no"
    NOT_DECIDED = "not decided"


@dataclass(frozen=True)
class Transplant(Plain):
    """The best reward of one place, used in another.

    Attributes:
        chosen: The best reward in the place where the choice was made.
        best: The best reward in the place where it is used.
        cost: By how much `chosen` is behind `best` there; 0 if they are the same. The interval, 0 or more, is of what
            it costs against the truly best one there. The note says why there is no decision.
        answer: Whether another reward would have been chosen there.
    """

    chosen: str
    best: str
    cost: Estimate
    answer: Answer

    @property
    def is_costly(self) -> bool:
        """Whether the choice certainly costs something, no matter what would have been chosen there."""
        return bool(self.cost.low)


def order_rewards(places: Sequence[Runs], episodes: Sequence[int | None]) -> list[Order]:
    """The order of the rewards in each place, with intervals that hold together.

    Args:
        places: The seeds' values in each place. All places have the same rewards.
        episodes: How many episodes the values of each place are shares of; None if they are no shares.
    """
    rewards = len(places[0])  # r - 1 bounds in a place are of the best one, r (r - 1) of any two
    wrong = 2.0 * (1.0 - CONFIDENCE) / max(len(places) * (rewards - 1), 1)
    confidences = (1.0 - wrong / rewards, 1.0 - wrong)
    return [_order(place, of, confidences) for place, of in zip(places, episodes, strict=True)]


def _order(runs: Runs, episodes: int | None, confidences: tuple[float, float]) -> Order:
    values = np.array(list(runs.values()), np.float64)  # (rewards, seeds)
    count, seeds = values.shape
    low = np.tile(np.where(np.eye(count), 0.0, -np.inf), (2, 1, 1))
    ends = UNBOUNDED if episodes is None else SHARE
    if not why_no_interval(seeds):
        sides = [Side([of], [ends]) for of in values]
        for which, (one, other) in product(range(2), combinations(range(count), 2)):
            found = difference_bounds(sides[other], sides[one], confidences[which])
            low[which, one, other], high = cut_to(found, of_difference(ends))
            low[which, other, one] = -high
    return Order(tuple(runs), values.mean(axis=1), low[0], low[1], seeds)


def agreement_of(one: Order, other: Order) -> Estimate:
    """Kendall's tau-b of two orders of the same rewards, with an interval that spans all orders that are left.

    It is 1 for the same order, -1 for the opposite one, 0 for unrelated ones; without a value where all rewards of a
    place have the same one.
    """
    pairs = np.triu_indices(len(one.rewards), 1)
    signs = [np.sign(np.round(it.means[pairs[0]] - it.means[pairs[1]], 12)).astype(np.int64) for it in (one, other)]
    tau = kendall(*signs)
    if tau is None:
        return Estimate(None, notes=("in a place all rewards come to the same: they have no order",))
    seeds = min(one.seeds, other.seeds)
    if too_few := why_no_interval(seeds):
        return Estimate(tau, None, None, seeds, too_few)
    low, high = tau_range(one.signs[pairs], other.signs[pairs])
    return Estimate(tau, low, high, seeds, OPEN * ((low, high) == (-1.0, 1.0)))


def kendall(one: Signs, other: Signs) -> float | None:
    """Tau-b of two orders, from their signs for each two rewards, (pairs,): the cosine of the angle between them."""
    lengths = math.sqrt(float((one**2).sum() * (other**2).sum()))
    return float((one * other).sum()) / lengths if lengths else None


def tau_range(one: Signs, other: Signs) -> tuple[float, float]:
    """The smallest and the largest tau-b that two orders may have. A sign of 0 is uncertain, (pairs,)."""
    return -_largest_tau(one, -other), _largest_tau(one, other)


def _largest_tau(one: Signs, other: Signs) -> float:
    """The largest tau-b. An uncertain pair may agree or be a tie, and a tie may be the better choice.

    Only numbers of pairs count: of those that one place alone tells, and that neither does, 0 to all may be made agree.
    """
    told, agree = (one != 0) & (other != 0), int((one * other).sum())
    alone = [int(((it != 0) & ~told).sum()) for it in (one, other)]
    free = int(((one == 0) & (other == 0)).sum())
    both = int(told.sum())
    first, second, third = np.ix_(np.arange(alone[0] + 1), np.arange(alone[1] + 1), np.array([0, free]))
    lengths = (both + alone[0] + second + third) * (both + alone[1] + first + third)
    ordered = lengths > 0  # else all pairs of a place would be ties
    taus = np.where(ordered, (agree + first + second + third) / np.sqrt(np.maximum(lengths, 1)), -1.0)
    return min(float(taus.max()), 1.0)


def mean_agreement(found: Sequence[tuple[str, str, Estimate]]) -> Estimate:
    """The mean tau of pairs of places, where places with one name have one vote.

    Args:
        found: For each pair of places the names of both votes, and their agreement.
    """
    votes: dict[frozenset[str], list[Estimate]] = {}
    for one, other, agreement in found:
        if one != other and agreement.value is not None:
            votes.setdefault(frozenset((one, other)), []).append(agreement)
    if not votes:
        return Estimate(None, notes=("there are no two independent votes with an order",))
    means = [[_mean([getattr(it, end) for it in them]) for them in votes.values()] for end in ("value", "low", "high")]
    tau, low, high = (_mean(values) for values in means)
    seeds = min(it.seeds for them in votes.values() for it in them)
    return Estimate(tau, low, high, seeds, NO_INTERVAL if low is None else OPEN * ((low, high) == (-1.0, 1.0)))


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return math.fsum(known) / len(known) if known and len(known) == len(values) else None


def transplant(here: Order, there: Order, margin: float = SUCCESS_MARGIN) -> Transplant:
    """The cost of choosing the best reward of one place and using it in another place.

    Yes: no reward that may be the best one here may be the best one there. No: it costs less than `margin` there,
    whichever reward is the best one there. All answers about all places hold together in 95 % of the experiments.

    Args:
        here: Where the reward is chosen.
        there: Where it is used; the same rewards.
        margin: A smaller cost counts as none.
    """
    chosen, best = here.best, there.best
    cost, seeds = float(there.means[best] - there.means[chosen]), min(here.seeds, there.seeds)
    if there.means[chosen] == there.means[best]:
        best = chosen
    names = (here.rewards[chosen], here.rewards[best])
    if too_few := why_no_interval(seeds):
        return Transplant(*names, Estimate(cost, None, None, seeds, too_few), Answer.NOT_DECIDED)
    low, high = float(there.low[:, chosen].max()), max(0.0, float(-there.low_of_best[chosen].min()))
    answer = Answer.NO if high <= margin else Answer.NOT_DECIDED
    if not set(here.candidates) & set(there.candidates):
        answer = Answer.YES
    notes = (_what_is_open(here, there, chosen),) * (answer is Answer.NOT_DECIDED)
    return Transplant(*names, Estimate(cost, low, high, seeds, notes), answer)


def _what_is_open(here: Order, there: Order, chosen: int) -> str:
    if chosen in there.candidates:
        others = [there.rewards[it] for it in there.candidates if it != chosen]
        return f"{', '.join(others)} may be better there" if others else "it may be the best one there by less"
    rivals = [here.rewards[it] for it in here.candidates if it != chosen]
    return f"where it was chosen, {', '.join(rivals)} may be as good"
