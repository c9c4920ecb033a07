"""A race of several rewards for the best one: who is beaten by a living one leaves, and is trained no further."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from harness.arrays import Float
from harness.eta.interval import quantile
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


def race(values: Mapping[str, Float], looks: Sequence[int], complete: Mapping[str, int]) -> Race:
    """How a race stands.

    A candidate leaves once a living one beats it by Welch's one-sided t test. A look adds a part of the 5 %, which is
    shared by all living ones but one: so many could beat the best. Who leaves makes the share of the others larger.

    Args:
        values: What decides of each candidate, higher is better, (places, seeds), NaN where a seed left no value; the
            seeds of the first look first. The first axis has equal length in all.
        looks: Seeds in each place at each look, increasing.
        complete: How many looks are complete for each candidate.
    """
    living, beaten, done = list(values), dict[str, Beaten](), 0
    for look, seeds in enumerate(looks):
        if any(complete[name] <= look for name in living):
            break
        done = look + 1
        before = spent(looks[look - 1], looks[-1]) if look else 0.0
        level = spent(seeds, looks[-1]) - before
        there = {name: values[name][:, :seeds] for name in living}
        without = [name for name in living if np.isfinite(there[name]).sum(axis=1).min() < 2]
        beaten |= {name: Beaten(look, "") for name in without}
        living = sorted((name for name in living if name not in without), key=lambda name: -_mean(there[name]))
        found = _beaten(there, living, level)
        beaten |= {name: Beaten(look, by) for name, by in found.items()}
        living = [name for name in living if name not in found]
        share = level / max(1, len(living) - 1)
        is_close = len(living) > 1 and all(_reach(there[living[0]], there[name], share) < CLOSE for name in living[1:])
        if len(living) < 2 or is_close:
            return Race(done, tuple(living), beaten, is_close, True)
    return Race(done, tuple(living), beaten, False, done == len(looks))


def _beaten(there: Mapping[str, Float], living: Sequence[str], level: float) -> dict[str, str]:
    """Who leaves at a look, and beaten by whom; the best mean comes first."""
    found: dict[str, str] = {}
    while len(left := [name for name in living if name not in found]) > 1:
        share = level / (len(left) - 1)
        by = {name: next((it for it in left if _beats(there[it], there[name], share)), "") for name in left[1:]}
        leaving = {name: it for name, it in by.items() if it}
        if not leaving:
            break
        found |= leaving
    return found


def _mean(values: Float) -> float:
    return float(np.nanmean(values, axis=1).mean())


def _apart(one: Float, other: Float) -> tuple[float, float, float]:
    """The difference of two means over places, its standard error and degrees of freedom (Welch)."""
    parts = np.array([np.nanvar(side, axis=1, ddof=1) / np.isfinite(side).sum(axis=1) for side in (one, other)])
    parts /= one.shape[0] ** 2
    counts = np.array([np.isfinite(side).sum(axis=1) for side in (one, other)])
    total = float(parts.sum())
    squares = float((parts**2 / (counts - 1)).sum())
    return _mean(one) - _mean(other), math.sqrt(total), total**2 / squares if squares > 0.0 else 1.0


def _beats(one: Float, other: Float, level: float) -> bool:
    difference, error, freedom = _apart(one, other)
    return difference > quantile(1.0 - 2.0 * level, freedom) * error and difference > 0.0


def _reach(best: Float, other: Float, level: float) -> float:
    """How much worse than the best another one can be at most."""
    difference, error, freedom = _apart(best, other)
    return difference + quantile(1.0 - 2.0 * level, freedom) * error
