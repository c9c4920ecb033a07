"""What a search found at one start, and in a world: the three numbers that an answer rests on."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from .world import Actions


@dataclass(frozen=True, eq=False)
class Behaviour:
    """One episode that a search keeps.

    Attributes:
        start: The seed of its reset.
        actions: Those that it took, as long as it was.
        paid: What it was paid in all.
        discounted: The same times gamma^t.
        success: Whether it ended in success.
        steps: Its length.
        time: The step from which on it was a success, from 1; the horizon for a failure.
        share: The share of its steps that were a success.
        measures: By name, the last value of each measure.
        made_by: What it comes from, in words: ``search``, ``script creep``, ``policy``, ``linear policy``, ``table``.
        policy: Whoever acted, as plain data, if anybody did: weights of a linear policy, a table's choices. With it
            the behaviour can be begun elsewhere too. None of a bare sequence of actions.
    """

    start: int
    actions: Actions
    paid: float
    discounted: float
    success: bool
    steps: int
    time: int
    share: float
    measures: Mapping[str, float] = field(default_factory=dict)
    made_by: str = "search"
    policy: Mapping[str, Any] | None = None


@dataclass(frozen=True, eq=False)
class Three:
    """The three behaviours of one start; None where none was found.

    Attributes:
        failure: The best-paid one that does not succeed.
        success: The best-paid one that does.
        fastest: The best-paid one of those that succeed about as fast as the fastest.
    """

    start: int
    failure: Behaviour | None
    success: Behaviour | None
    fastest: Behaviour | None


@dataclass(frozen=True, eq=False)
class Searched:
    """What a search found.

    Attributes:
        plain: By the sum of pay, a `Three` for each start.
        discounted: By the discounted sum, the same.
        typical: Of each start, what random actions were paid: the median, (starts,).
        typical_discounted: The same, discounted.
        successes: Of each start, how many different successes were met.
        climbing: Of each start, by how much the best-paid success still rose in the last fifth of the search.
        steps: Steps taken.
        how: What searched: ``sequences``, ``linear policies``, ``table``; the last is exact.
    """

    plain: Sequence[Three]
    discounted: Sequence[Three]
    typical: Sequence[float]
    typical_discounted: Sequence[float]
    successes: Sequence[int]
    climbing: Sequence[float]
    steps: int
    how: tuple[str, ...]
