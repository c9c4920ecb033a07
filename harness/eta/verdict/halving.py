"""Sequential halving of several rewards: the worse ones leave at each rung, and one goes furthest.

It promises nothing: whoever leaves may be as good. So the one that went furthest is asked about by itself, on trainings
that had no part in choosing it (Karnin, Koren and Somekh 2013; the question is the ordinary one, see `ruling`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import comb, isfinite
from typing import NamedTuple

import numpy as np

from harness.arrays import Float
from harness.eta.interval import Bounds
from harness.eta.verdict.ruling import LEVEL
from harness.files.plain import Plain, tells

KEPT = ((1, 2), (2, 5))
"""The share that stays at a rung, as a fraction: half, or where the budget is too small for that, two fifths."""
OF_BUDGET = 2
"""Choosing takes at most a half of the budget, unless one training of each takes more."""
USUAL, OF_EACH = 20, 4
"""The usual budget in a place: so many trainings, and so many for each candidate."""
MOST = 4
"""A budget in minutes is at most so many usual ones: all trainings that may be needed are planned before the first."""


class Rung(NamedTuple):
    """A rung: so many candidates have so many trainings each in each place, those of the rungs before included."""

    candidates: int
    seeds: int


class Schedule(NamedTuple):
    """How a budget is spent."""

    rungs: tuple[Rung, ...]
    fresh: int
    """New trainings in each place of the one that went furthest, and of the baseline."""

    @property
    def seeds(self) -> int:
        """The most trainings of a candidate in a place before it is chosen."""
        return self.rungs[-1].seeds

    def trainings(self, places: int) -> int:
        """How many trainings it takes."""
        return places * (_cost(self.rungs) + 2 * self.fresh)


def usual(candidates: int, places: int) -> int:
    """The usual budget, in trainings."""
    return places * (USUAL + OF_EACH * candidates)


def fewest(candidates: int, places: int) -> int:
    """The smallest budget with which anything can be said: one training of each, and new ones that could tell."""
    return places * (candidates + 2 * _fewest_fresh(places))


def _fewest_fresh(places: int) -> int:
    """So many new trainings in each place, dealt anew, can be rarer than the level."""
    fresh = 2
    while 2 / comb(2 * fresh, fresh) ** places > LEVEL:
        fresh += 1
    return fresh


def schedule_of(candidates: int, budget: int, places: int) -> Schedule:
    """How a budget of trainings is spent, at least `fewest`."""
    of_place = budget // places
    room = min(of_place // OF_BUDGET, of_place - 2 * _fewest_fresh(places))
    for stay, of in KEPT:
        counts = [candidates]
        while counts[-1] > 2:  # of an odd number the half that stays is the larger one
            counts.append(max(2, -(-counts[-1] * stay // of) if of == 2 else counts[-1] * stay // of))
        times = room // _cost(_rungs(counts, 1))
        if times:
            rungs = _rungs(counts, times)
            return Schedule(rungs, (of_place - _cost(rungs)) // 2)
    return Schedule((Rung(candidates, 1),), (of_place - candidates) // 2)


def _rungs(counts: Sequence[int], times: int) -> tuple[Rung, ...]:
    return tuple(Rung(count, times * 2**at) for at, count in enumerate(counts))


def _cost(rungs: Sequence[Rung]) -> int:
    """The trainings of rungs in a place."""
    before = [0, *(it.seeds for it in rungs)]
    return sum(it.candidates * (it.seeds - of) for it, of in zip(rungs, before, strict=False))


@tells("means", "left", "furthest")
@dataclass(frozen=True)
class Halving(Plain):
    """How far candidates went.

    Attributes:
        means: By rung that is complete, the mean of each candidate that was left, the best first; None without a value.
        left: Who goes on; the first one went furthest, as far as it is known.
        is_over: Whether all rungs are complete.
    """

    means: tuple[Mapping[str, float | None], ...]
    left: tuple[str, ...]
    is_over: bool

    @property
    def furthest(self) -> str | None:
        """The one that went furthest; None before all rungs are complete."""
        return self.left[0] if self.is_over and self.left else None


def halve(
    values: Mapping[str, Float], rungs: Sequence[Rung], complete: Mapping[str, int], ends: Sequence[Bounds]
) -> Halving:
    """Let the worse candidates leave at each rung, by the mean over places, then over seeds.

    Args:
        values: What decides of each candidate, higher is better, (places, seeds); NaN where a training left no value:
            it counts as the worst that there is, and where that is not known its candidate comes last.
        rungs: The rungs.
        complete: How many trainings of each candidate have ended in all places, without a gap.
        ends: What a value can be, by place.
    """
    worst = np.array([[low if isfinite(low) else -np.inf] for low, _ in ends])
    left, means = list(values), list[dict[str, float | None]]()
    for at, rung in enumerate(rungs):
        if any(complete[name] < rung.seeds for name in left):
            return Halving(tuple(means), tuple(left), False)
        found = {name: _mean(values[name][:, : rung.seeds], worst) for name in left}
        order = sorted(left, key=found.__getitem__, reverse=True)
        means.append({name: found[name][0] if isfinite(found[name][0]) else None for name in order})
        left = order[: rungs[at + 1].candidates if at + 1 < len(rungs) else 1]
    return Halving(tuple(means), tuple(left), True)


def _mean(values: Float, worst: Float) -> tuple[float, int]:
    """The mean, and how many trainings have a value: of two that are as good, who has more of them."""
    lost = np.isnan(values)
    return float(np.where(lost, worst, values).mean(axis=0).mean()), -int(lost.sum())
