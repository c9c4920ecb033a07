"""What a search keeps of all the episodes that it tries: of each start the best-paid, under both sums of pay.

`Cells` keeps where episodes went: rare places are begun from again, so that a success that is told late is met.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import gymnasium
import numpy as np

from harness import Float, Ints

from .behaviour import AS_FAST, Behaviour, Role, Three
from .moves import Feedback
from .world import Actions, Data, Outcomes, Rng

PLACES = 600
"""Observations are cut into about so many cells, if they are few numbers."""
COARSEST = 3
"""Each number into at least so many."""
MOST = 20_000
"""Cells that are kept; what is new after that is not."""


class Way(NamedTuple):
    """A whole sequence of actions, as a search writes them."""

    genes: Actions
    """The actions, (horizon, ...)."""
    length: int = 0
    """How many steps its episode was long; what it had done later is there too."""
    hold: Feedback | None = None
    """By what it held, if it did."""


class Cells:
    """For each cell of observations the shortest known way there, and how many episodes went through it."""

    def __init__(self, observes: gymnasium.Space[Any]) -> None:
        self._low = self._width = np.zeros(0)  # open bounds: the first episode tells
        if isinstance(observes, gymnasium.spaces.Box) and np.isfinite([observes.low, observes.high]).all():
            self._cut(np.stack([observes.low.ravel(), observes.high.ravel()]).astype(np.float64), 1e-9)
        self.ways: dict[bytes, Way] = {}
        self._visits: dict[bytes, int] = {}

    def _cut(self, seen: Float, least: float) -> None:
        """Cut what lies between observations into cells, each at least so wide."""
        parts = max(COARSEST, round(float(PLACES ** (1.0 / max(seen.shape[1], 1)))))
        self._low, self._width = seen.min(axis=0), np.maximum(np.ptp(seen, axis=0), least) / parts

    def add(self, trail: Float, genes: Actions) -> None:
        """Note where an episode went.

        Args:
            trail: Its observations, (steps + 1, size).
            genes: Its actions, (horizon, ...).
        """
        if len(self._low) != trail.shape[1]:
            self._cut(trail, 1e-6)
        keys = np.floor((trail - self._low) / self._width).clip(-1e6, 1e6).astype(np.int32)
        cells, first = np.unique(keys, axis=0, return_index=True)
        for key, step in zip(map(np.ndarray.tobytes, cells), first.tolist(), strict=True):
            if key in self.ways or len(self.ways) < MOST:
                self._visits[key] = self._visits.get(key, 0) + 1
                if step < self.ways.setdefault(key, Way(genes, step)).length:
                    self.ways[key] = Way(genes, step)

    def draw(self, rng: Rng, count: int) -> list[Way]:
        """Ways to cells, rare ones more often."""
        ways, weights = list(self.ways.values()), 1.0 / np.sqrt(np.array(list(self._visits.values()), np.float64))
        return [ways[it] for it in rng.choice(len(ways), count, p=weights / weights.sum())]


AS_PAID = 0.01
"""A success is about as well paid as the best-paid one if it is paid so much less at most, as a share of what lies
between the best pay and what random actions are paid."""
OF_GAIN, OF_LEAD = 0.2, 0.5
"""Or if it is paid less by this share of what the best-paid success gains over the fastest one, but not by more than
this share of its lead over failures: where pay grows with time as a loop's does, the rest is still late."""
NUMBERS = "paid", "discounted", "success", "steps", "time", "share"
"""What is kept of what an episode came to."""
EQUAL = 1e-6
"""Sums of pay are the same that differ by no more than this, of themselves or of 1."""


@dataclass(eq=False)
class Bests:
    """The best-paid episodes of one start, under one sum of pay.

    Attributes:
        horizon: The most steps of an episode.
        failure: The best-paid failure.
        successes: By time, the successes that are paid more than every faster one.
        failure_pay: What the best-paid failure is paid; minus infinity if none was met.
    """

    horizon: int
    failure: Behaviour | None = None
    successes: dict[int, Behaviour] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.failure_pay = -np.inf
        self._success = np.full(self.horizon + 1, -np.inf)

    def is_better(self, success: bool, time: int, pay: float) -> bool:
        """Whether such an episode would be kept."""
        return bool(pay > (self._success[time] if success else self.failure_pay))

    def keep(self, behaviour: Behaviour, pay: float) -> None:
        """Keep an episode, in the place of those that it makes needless."""
        if not behaviour.success:
            self.failure, self.failure_pay = behaviour, pay
            return
        worse = [at for at in self.successes if at >= behaviour.time and self._success[at] <= pay]
        for at in worse:
            del self.successes[at]
        self.successes[behaviour.time] = behaviour
        self._success[behaviour.time :] = np.maximum(self._success[behaviour.time :], pay)

    @property
    def success_pay(self) -> float:
        """What the best-paid success is paid; minus infinity if none was met."""
        return float(self._success[-1])

    def three(self, typical: float, is_searched: bool = True) -> Three:
        """The best-paid failure, the best-paid success, and the best-paid one of the fastest.

        Of successes that are about as well paid as the best one, the fastest stands for it: that a search has found a
        slow one that is paid a trifle more says nothing of the reward.
        """
        times, found = sorted(self.successes), dict[Role, Behaviour]()
        if self.failure is not None:
            found["failure"] = self.failure
        if not times:
            return found
        best, as_fast = self.success_pay, max(at for at in times if at <= AS_FAST * times[0])
        trifle = AS_PAID * max(0.0, best - typical, self.failure_pay - typical)
        saved = min(OF_GAIN * (best - self._success[as_fast]), OF_LEAD * (best - self.failure_pay))
        less = max(trifle, saved) if is_searched else 0.0
        as_paid = next(at for at in times if self._success[at] >= best - less)
        return {**found, "success": self.successes[max(as_paid, as_fast)], "fastest": self.successes[as_fast]}


class Kept:
    """The bests of all starts. Everything that a search plays goes through `add`.

    Attributes:
        starts: The seeds that are searched, (starts,).
        plain: By the sum of pay, of each start.
        discounted: By the discounted sum.
    """

    def __init__(self, starts: Sequence[int], horizon: int) -> None:
        self.starts: Ints = np.asarray(starts, np.int64)
        self.plain = [Bests(horizon) for _ in starts]
        self.discounted = [Bests(horizon) for _ in starts]
        self._met: list[set[int]] = [set() for _ in starts]

    @property
    def successes(self) -> list[int]:
        """How many different successes were met, of each start."""
        return [len(met) for met in self._met]

    def is_paid_more_than(self, other: "Kept") -> bool:
        """Whether a failure or a success of any start is paid more here, or is known here alone."""
        here, there = (
            np.array([[it.failure_pay, it.success_pay] for it in (*of.plain, *of.discounted)]) for of in (self, other)
        )
        return bool(((here > there) & ~np.isclose(here, there, rtol=EQUAL, atol=EQUAL)).any())

    def add(
        self,
        rows: Ints,
        actions: Sequence[Actions] | Actions,
        outcomes: Outcomes,
        made_by: str,
        policies: Sequence[Data | None] = (),
    ) -> None:
        """Keep what is better than what was kept.

        Args:
            rows: Of each episode, which start it began at, as a place in `starts`, (n,).
            actions: What it took; what lies behind its last step is left out.
            outcomes: What it came to.
            made_by: What it comes from.
            policies: Who acted, as plain data; none for bare sequences.
        """
        for k in np.flatnonzero(outcomes.success).tolist():
            self._met[rows[k]].add(hash(np.ascontiguousarray(actions[k][: outcomes.steps[k]]).tobytes()))
        for of, pays in ((self.plain, outcomes.paid), (self.discounted, outcomes.discounted)):
            # the best-paid episodes first; of each start's failures only the best one
            order = np.argsort(-pays, kind="stable")
            order = order[np.isfinite(pays[order])]
            failures, successes = order[~outcomes.success[order]], order[outcomes.success[order]]
            _, first = np.unique(rows[failures], return_index=True)
            for k in [*failures[first].tolist(), *successes.tolist()]:
                if not of[rows[k]].is_better(outcomes.success[k], outcomes.time[k], pays[k]):
                    continue
                numbers: Data = {name: getattr(outcomes, name)[k].item() for name in NUMBERS}
                measures = {name: values[k].item() for name, values in outcomes.measures.items()}
                taken, policy = np.array(actions[k][: outcomes.steps[k]]), policies[k] if len(policies) else None
                behaviour = Behaviour(
                    int(self.starts[rows[k]]), taken, **numbers, measures=measures, made_by=made_by, policy=policy
                )
                of[rows[k]].keep(behaviour, float(pays[k]))
