"""How an experiment with looks stands: which questions are over, and what is to be trained next."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from harness.eta.verdict.looks import LookRuling
from harness.record.cell import Cell
from harness.record.manifest import Manifest
from harness.record.terms import Terms
from harness.results.choosing import Choosing
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
        unanswered: Rewards that used all looks, and have no answer.
    """

    terms: Terms
    rewards: tuple[str, ...]
    open: tuple[str, ...]
    seen: Seen
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
        }


def standing_of(results: Results) -> Standing | Choosing | None:
    """How the experiment in a folder stands; None if its seeds were not planned to the end."""
    terms = results.plan.terms
    if results.choosing is not None:
        return results.choosing
    if not terms.looks:
        return None
    seen = Seen.of(results.manifests, terms.looks)
    rewards = tuple(sorted(dict.fromkeys(it for _, it in seen.status), key=lambda it: it != results.baseline))
    ruled = {it.proposed: (it.answer.pool or it.answer).ruling for it in results.combinations}
    over = {name: it for name, it in ruled.items() if isinstance(it, LookRuling) and it.is_over}
    left = [reward for reward in rewards[1:] if reward not in over]
    unanswered = tuple(name for name, it in over.items() if not it.is_decided and it.small is None)
    return Standing(terms, rewards, (rewards[0], *left) if left else (), seen, unanswered=unanswered)


def standing_to_json(standing: Standing | Choosing | None) -> dict[str, Any]:
    """Plain data: what reports and `harness status` say."""
    told = standing and standing.to_json()
    return {"looks": None, "choosing": told} if isinstance(standing, Choosing) else {"looks": told, "choosing": None}


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
