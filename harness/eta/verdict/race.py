"""A race of several rewards for the best one: who is beaten by a living one leaves, and is trained no further."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from harness.arrays import Float
from harness.eta.interval import UNBOUNDED, Bounds, Interval
from harness.eta.unseen import difference_bounds
from harness.eta.verdict.ruling import LEVEL

RACE = (4, 6, 8, 12, 16, 24, 32)
"""Seeds of each reward in each place at each look."""
CLOSE = 0.05
"""Rewards that are certainly within this of the best are as good."""


class Beaten(NamedTuple):
    """How a candidate left the race."""

    look: int
    """At which look, counted from 0."""
    by: str
    """Who beat it; empty if too few of its trainings left a number."""


@dataclass(frozen=True)
class Race:
    """How a race stands.

    Attributes:
        looks: How many looks are complete.
        living: Who can still be the best, the best mean first.
        beaten: Who cannot, and since when.
        is_close: Whether all that are left are within `CLOSE` of the best.
        is_over: Whether nothing more is to be trained.
    """

    looks: int
    living: tuple[str, ...]
    beaten: Mapping[str, Beaten]
    is_close: bool = False
    is_over: bool = False

    @property
    def best(self) -> str | None:
        """The only one that is left."""
        return self.living[0] if len(self.living) == 1 else None

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "looks": self.looks,
            "living": list(self.living),
            "beaten": {name: it._asdict() for name, it in self.beaten.items()},
            "best": self.best,
            "is_close": self.is_close,
            "is_over": self.is_over,
        }


def spent(seeds: int, most: int) -> float:
    """The chance that the best may have left wrongly after so many of at most so many seeds."""
    return LEVEL * (seeds / most) ** 2


def race(
    values: Mapping[str, Float],
    looks: Sequence[int],
    complete: Mapping[str, int],
    ends: Sequence[Bounds] | None = None,
) -> Race:
    """How a race stands.

    A candidate leaves once a living one beats it by Welch's one-sided t test. A look adds a part of the 5 %, which is
    shared by all living ones but one: so many could beat the best. Who leaves makes the share of the others larger.
    Trainings that were not seen count against all that is said, see `harness.eta.unseen`.

    Args:
        values: What decides of each candidate, higher is better, (places, seeds), NaN where a seed left no value; the
            seeds of the first look first. The first axis has equal length in all.
        looks: Seeds in each place at each look, increasing.
        complete: How many looks are complete for each candidate.
        ends: What a value can be, by place; by default anything.
    """
    living, beaten, done = list(values), dict[str, Beaten](), 0
    for number, seeds in enumerate(looks):
        if any(complete[name] <= number for name in living):
            break
        done = number + 1
        so_far = spent(seeds, looks[-1])
        before = spent(looks[number - 1], looks[-1]) if number else 0.0
        there = {name: values[name][:, :seeds] for name in living}
        without = [name for name in living if np.isfinite(there[name]).sum(axis=1).min() < 2]
        trainings = {name: tuple(place[np.isfinite(place)] for place in there[name]) for name in living}
        look = _Look(trainings, ends or [UNBOUNDED] * len(there[living[0]]), so_far - before, so_far)
        beaten |= {name: Beaten(number, "") for name in without}
        living = sorted((name for name in living if name not in without), key=look.mean, reverse=True)
        found = look.beaten(living)
        beaten |= {name: Beaten(number, by) for name, by in found.items()}
        living = [name for name in living if name not in found]
        is_close = len(living) > 1 and look.is_close(living)
        if len(living) < 2 or is_close:
            return Race(done, tuple(living), beaten, is_close, True)
    return Race(done, tuple(living), beaten, False, done == len(looks))


@dataclass(frozen=True, eq=False)
class _Look:
    """What a look at a race says.

    Attributes:
        trainings: The values of each candidate, by place.
        ends: What a value can be, by place.
        level: The part of the 5 % that this look adds.
        so_far: The part that this look and all before it have. The bounds with a training that was not seen take all
            of it: perfect trainings at an earlier look are among those of this one, so their luck counts once.
    """

    trainings: Mapping[str, Sequence[Float]]
    ends: Sequence[Bounds]
    level: float
    so_far: float

    def mean(self, name: str) -> float:
        """The mean of a candidate, over places."""
        return float(np.mean([place.mean() for place in self.trainings[name]]))

    def beaten(self, living: Sequence[str]) -> dict[str, str]:
        """Who leaves, and beaten by whom; the best mean of those who live comes first."""
        found: dict[str, str] = {}
        while len(left := [name for name in living if name not in found]) > 1:
            others = len(left) - 1
            by = {name: next((it for it in left if self._beats(it, name, others)), "") for name in left[1:]}
            leaving = {name: it for name, it in by.items() if it}
            if not leaving:
                break
            found |= leaving
        return found

    def _beats(self, one: str, other: str, others: int) -> bool:
        """Whether a candidate is better than another one, of so many that could be."""
        return self.mean(one) > self.mean(other) and self._ahead(one, other, others, self.so_far / others)[0] > 0.0

    def is_close(self, living: Sequence[str]) -> bool:
        """Whether all are within `CLOSE` of the best, which comes first."""
        return all(self._ahead(living[0], name, len(living) - 1, LEVEL)[1] < CLOSE for name in living[1:])

    def _ahead(self, one: str, other: str, others: int, unseen: float) -> Interval:
        """By how much a candidate is better than another one, at least and at most; see `difference_bounds`.

        Args:
            one: The candidate.
            other: The other one.
            others: How many share what this look adds.
            unseen: The level of the bounds with a training that was not seen.
        """
        of = self.trainings[other], self.trainings[one]
        return difference_bounds(*of, self.ends, 1.0 - 2.0 * unseen)
