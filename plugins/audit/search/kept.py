"""What a search keeps of all the episodes that it tries: of each start the best-paid, under both sums of pay."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .behaviour import Behaviour, Three
from .world import Actions, Outcomes, Whole

AS_FAST = 1.1
"""A success is about as fast as the fastest one if it takes at most so much longer."""
AS_PAID = 0.01
"""A success is about as well paid as the best-paid one if it is paid so much less at most, as a share of what lies
between the best pay and what random actions are paid."""

EQUAL = 1e-6
"""Sums of pay are the same that differ by no more than this, of themselves or of 1."""
OF_GAIN, OF_LEAD = 0.2, 0.5
"""Or if it is paid less by this share of what the best-paid success gains over the fastest one, but not by more than
this share of its lead over failures: where pay grows with time as a loop's does, the rest is still late."""


@dataclass(eq=False)
class Bests:
    """The best-paid episodes of one start, under one sum of pay.

    Attributes:
        horizon: The most steps of an episode.
        failure: The best-paid failure.
        successes: By time, the successes that are paid more than every faster one.
    """

    horizon: int
    failure: Behaviour | None = None
    successes: dict[int, Behaviour] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._failure = -np.inf
        self._success = np.full(self.horizon + 1, -np.inf)

    def is_better(self, success: bool, time: int, pay: float) -> bool:
        """Whether such an episode would be kept."""
        return bool(pay > (self._success[time] if success else self._failure))

    def keep(self, behaviour: Behaviour, pay: float) -> None:
        """Keep an episode, in the place of those that it makes needless."""
        if not behaviour.success:
            self.failure, self._failure = behaviour, pay
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

    @property
    def failure_pay(self) -> float:
        """What the best-paid failure is paid; minus infinity if none was met."""
        return float(self._failure)

    @property
    def is_failure_paid_more(self) -> bool:
        """Whether the best-paid failure is paid more than every success."""
        return bool(self._failure > self._success[-1])

    def three(self, start: int, typical: float, is_searched: bool = True) -> Three:
        """The best-paid failure, the best-paid success, and the best-paid one of the fastest.

        Of successes that are about as well paid as the best one, the fastest stands for it: that a search has found a
        slow one that is paid a trifle more says nothing of the reward.
        """
        times = sorted(self.successes)
        if not times:
            return Three(start, self.failure, None, None)
        best, as_fast = self.success_pay, max(at for at in times if at <= AS_FAST * times[0])
        trifle = AS_PAID * max(0.0, best - typical, self._failure - typical)
        saved = min(OF_GAIN * (best - self._success[as_fast]), OF_LEAD * (best - self._failure))
        less = max(trifle, saved) if is_searched else 0.0
        as_paid = next(at for at in times if self._success[at] >= best - less)
        return Three(start, self.failure, self.successes[max(as_paid, as_fast)], self.successes[as_fast])


class Kept:
    """The bests of all starts. Everything that a search plays goes through `add`.

    Attributes:
        starts: The seeds that are searched, (starts,).
        plain: By the sum of pay, of each start.
        discounted: By the discounted sum.
    """

    def __init__(self, starts: Sequence[int], horizon: int) -> None:
        self.starts: Whole = np.asarray(starts, np.int64)
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
        rows: Whole,
        actions: Sequence[Actions] | Actions,
        outcomes: Outcomes,
        made_by: str,
        policies: Sequence[Mapping[str, Any] | None] = (),
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
            for k in _promising(rows, outcomes, pays).tolist():
                best, pay = of[rows[k]], float(pays[k])
                if best.is_better(bool(outcomes.success[k]), int(outcomes.time[k]), pay):
                    policy = policies[k] if len(policies) else None
                    best.keep(behaviour_of(int(self.starts[rows[k]]), actions[k], outcomes, k, made_by, policy), pay)


def behaviour_of(
    start: int, actions: Actions, outcomes: Outcomes, k: int, made_by: str, policy: Mapping[str, Any] | None = None
) -> Behaviour:
    """Episode k of some outcomes, as a behaviour."""
    steps = int(outcomes.steps[k])
    return Behaviour(
        start=start,
        actions=np.array(actions[:steps]),
        paid=float(outcomes.paid[k]),
        discounted=float(outcomes.discounted[k]),
        success=bool(outcomes.success[k]),
        steps=steps,
        time=int(outcomes.time[k]),
        share=float(outcomes.share[k]),
        measures={name: float(values[k]) for name, values in outcomes.measures.items()},
        made_by=made_by,
        policy=policy,
    )


def _promising(rows: Whole, outcomes: Outcomes, pays: NDArray[Any]) -> NDArray[Any]:
    """The best-paid episodes first; of each start's failures only the best one."""
    order = np.argsort(-pays, kind="stable")
    failures = order[~outcomes.success[order] & np.isfinite(pays[order])]
    _, first = np.unique(rows[failures], return_index=True)
    return np.concatenate([failures[first], order[outcomes.success[order] & np.isfinite(pays[order])]])
