"""What a search found at one start, and in a world: the three numbers that an answer rests on."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias, get_args

from harness.files.plain import Plain, tells

from .world import Actions, Data, Outcomes

Role: TypeAlias = Literal["failure", "success", "fastest"]
ROLES: tuple[Role, ...] = get_args(Role)
AS_FAST = 1.1
"""A success is about as fast as the fastest one if it takes at most so many times as long."""


@tells("start", "paid", "discounted", "success", "steps", "time", "share", "made_by")
@dataclass(frozen=True, eq=False)
class Behaviour(Plain):
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
    policy: Data | None = None

    def to_json(self) -> dict[str, Any]:
        """Plain data, finite numbers only."""
        measures = {name: value if math.isfinite(value) else None for name, value in self.measures.items()}
        return {**super().to_json(), "measures": measures}


Three: TypeAlias = Mapping[Role, Behaviour]
"""The three behaviours of one start, as far as they were found, in the order of `ROLES`.

``failure`` is the best-paid one that does not succeed, ``success`` the best-paid one that does, and ``fastest`` the
best-paid one of those that succeed about as fast as the fastest.
"""


@dataclass(frozen=True, eq=False)
class Rated:
    """A policy on held-out starts: those that no search has played.

    Attributes:
        policy: As plain data; `act_of` makes it act.
        starts: The seeds of the resets, the same ones for every policy that it is compared with.
        outcomes: What its episodes came to, one for each start.
        actions: Those of its first episode.
    """

    policy: Data
    starts: Sequence[int]
    outcomes: Outcomes
    actions: Actions


Rates: TypeAlias = Mapping[str, Rated]
"""The policies that an answer rests on where chance decides: failure and success are rates there.

``paid`` is the one that is paid most by the sum of pay, ``discounted`` by the discounted sum. ``success`` is the one
that succeeds most often; of several, the one that is paid most. ``fastest`` is the one whose success comes soonest on
average, of those that succeed about as often. Both are left out if none ever did. ``random`` acts at random.
"""


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
        how: What searched: ``sequences``, ``linear policies``, ``table``, ``sampled table``; only ``table`` is exact.
        rates: Where chance decides, what policies come to on held-out starts. An answer rests on these then, and
            `plain` and `discounted` may be empty.
    """

    plain: Sequence[Three]
    discounted: Sequence[Three]
    typical: Sequence[float]
    typical_discounted: Sequence[float]
    successes: Sequence[int]
    climbing: Sequence[float]
    steps: int
    how: tuple[str, ...]
    rates: Rates | None = None
