"""How an experiment with looks stands: which questions are over, and what is to be trained next."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from harness.arrays import Float
from harness.eta.interval import UNBOUNDED
from harness.eta.manner import LAST
from harness.eta.verdict.looks import LookRuling
from harness.eta.verdict.race import Race, race
from harness.record.cell import Cell
from harness.record.manifest import Manifest
from harness.record.terms import Terms
from harness.results.measured import last_values
from harness.results.results import Results
from harness.results.verdicts import Seen


@dataclass(frozen=True, eq=False)
class Standing:
    """How an experiment with looks stands.

    Attributes:
        terms: What was agreed on before the first training.
        rewards: All rewards, the baseline first.
        open: Those that are trained further; the baseline is among them as long as any other is.
        seen: The trainings.
        race: In a race for the best reward: how it stands.
        unanswered: Rewards that used all looks, and have no answer.
    """

    terms: Terms
    rewards: tuple[str, ...]
    open: tuple[str, ...]
    seen: Seen
    race: Race | None = None
    unanswered: tuple[str, ...] = ()

    @property
    def is_over(self) -> bool:
        """Whether nothing more is to be trained."""
        return not self.open

    @property
    def look(self) -> int:
        """The look that comes next, counted from 0."""
        return min((self.seen.complete(reward) for reward in self.open), default=len(self.terms.looks))

    @property
    def next(self) -> list[Cell]:
        """The cells of the next look, and of those before it, that an answer waits for."""
        return [] if self.is_over else self.seen.cells_of(self.open, min(self.look, len(self.terms.looks) - 1))

    @property
    def most_left(self) -> int:
        """How many trainings there can be at most until everything is over."""
        return len(self._pending) - len(self.not_needed)

    @cached_property
    def not_needed(self) -> frozenset[Cell]:
        """The pending cells that no answer waits for."""
        return self._pending.difference(self.seen.cells_of(self.open, len(self.terms.looks) - 1))

    @cached_property
    def _pending(self) -> frozenset[Cell]:
        statuses = self.seen.status.values()
        return frozenset(cell for cells in statuses for cell, status in cells.items() if status == "pending")

    @property
    def text(self) -> str:
        """How it stands, in a line."""
        left = "" if self.is_over else f", at most {self.most_left} trainings left"
        if self.race is not None:
            return f"{len(self.race.living)} of {len(self.rewards)} rewards can still be the best{left}"
        others = len(self.rewards) - 1
        decided = others - len(self.open[1:]) - len(self.unanswered)
        unanswered = f", {len(self.unanswered)} without an answer (all looks are used)" if self.unanswered else ""
        return f"{decided} of {others} decided{unanswered}{left}"

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "looks": list(self.terms.looks),
            "next_look": self.look + 1,
            "open": list(self.open),
            "most_trainings_left": self.most_left,
            "race": self.race and self.race.to_json(),
        }


def standing_of(results: Results) -> Standing | None:
    """How the experiment in a folder stands; None if it has no looks."""
    terms = results.plan.terms
    if not terms.looks:
        return None
    seen = Seen.of(results.manifests, terms.looks)
    rewards = tuple(sorted(dict.fromkeys(it for _, it in seen.status), key=lambda it: it != results.baseline))
    if terms.race:
        complete = {reward: seen.complete(reward) for reward in rewards}
        values = {reward: values_of(results, seen, reward) for reward in rewards}
        of_place = {it.group: it.decisive for it in results.combinations}
        decided = [it.measure if (it := of_place.get(group)) else None for group in seen.groups]
        bounds = [(it.ends, it.better) if it else (UNBOUNDED, "") for it in decided]
        ends = [(-high, -low) if better == "lower" else (low, high) for (low, high), better in bounds]
        found = race(values, seen.looks, complete, ends)
        return Standing(terms, rewards, () if found.is_over else found.living, seen, found)
    ruled = {it.proposed: (it.answer.pool or it.answer).ruling for it in results.combinations}
    over = {name: it for name, it in ruled.items() if isinstance(it, LookRuling) and it.is_over}
    left = [reward for reward in rewards[1:] if reward not in over]
    unanswered = tuple(name for name, it in over.items() if not it.is_decided and it.small is None)
    return Standing(terms, rewards, (rewards[0], *left) if left else (), seen, unanswered=unanswered)


def told_manifests(results: Results) -> list[Manifest]:
    """How each cell ended, in the order of the plan. Pending ones that no answer waits for are *not needed*."""
    standing = standing_of(results)
    if standing is None:
        return results.manifests
    spared = standing.not_needed
    return [
        replace(it, status="not needed", reason="the answer stands without it") if it.cell in spared else it
        for it in results.manifests
    ]


def values_of(results: Results, seen: Seen, reward: str) -> Float:
    """What decides of one reward, higher is better, (places, seeds); NaN where a training left no value."""
    of_place = {it.group: it for it in results.combinations}
    values = np.full((len(seen.groups), seen.looks[-1]), np.nan)
    for place, group in enumerate(seen.groups):
        for at, (cell, status) in enumerate(seen.status.get((group, reward), {}).items()):
            it = of_place.get(group) if status == "done" else None
            if it is None:
                continue
            if it.answered_in == LAST:
                told = last_values(results.moments(cell), cell.steps, results.plan.terms.averaged)
            else:
                told = results.measured(cell).manners.get(it.manner, {})
            value = told.get(next(iter(it.measured.deciding), ""))
            if value is not None:
                values[place, at] = -value if it.decisive and it.decisive.measure.better == "lower" else value
    return values
