"""How `harness choose` stands: who went how far, what is trained next, and which trainings are compared."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property
from typing import Any

import numpy as np

from harness.arrays import Float
from harness.eta.interval import UNBOUNDED, Bounds
from harness.eta.manner import LAST
from harness.eta.verdict.halving import Halving, Schedule, fewest, halve, schedule_of
from harness.files.plain import Plain, tells, to_plain
from harness.record.cell import Cell, Manifest
from harness.record.terms import Terms
from harness.results.comparison import ENDED, Group, Seen, deciding_manner
from harness.results.trainings import Match, Trained, Trainings


@tells("budget", "*halving", "most_trainings_left=most_left", "is_over")
@dataclass(frozen=True, eq=False)
class Choosing(Plain):
    """How an experiment stands that sees which of several rewards goes furthest, and asks about that one.

    Attributes:
        terms: What was agreed on before the first training.
        baseline: The reward that the others are compared with, no candidate itself.
        manifests: Of all planned cells, in order.
        trainings: What there is of the cells that are done, by group.
    """

    terms: Terms
    baseline: str
    manifests: Sequence[Manifest]
    trainings: Sequence[Trainings]

    @cached_property
    def _seen(self) -> Seen:
        return Seen.of(self.manifests, ())

    @cached_property
    def _skipped(self) -> set[tuple[Group, str]]:
        """What cannot work, or was left out."""
        return {key for key, cells in self._seen.status.items() if set(cells.values()) == {"skipped"}}

    @cached_property
    def candidates(self) -> tuple[str, ...]:
        """The rewards that can be chosen, in the order of the plan."""
        there = (reward for key in self._seen.status if key not in self._skipped for reward in key[1:])
        return tuple(it for it in dict.fromkeys(there) if it != self.baseline)

    @cached_property
    def places(self) -> tuple[Group, ...]:
        """The places in which candidates train."""
        groups = self._seen.groups
        return tuple(it for it in groups if any((it, name) not in self._skipped for name in self.candidates))

    def _cells(self, group: Group, reward: str) -> list[Cell]:
        return list(self._seen.status.get((group, reward), {}))

    @cached_property
    def per_training(self) -> float | None:
        """The seconds that a training took, by the first one of each candidate; None before they have ended."""
        first = {self._cells(group, name)[0] for group in self.places for name in self.candidates}
        ended = [it for it in self.manifests if it.cell in first]
        if any(it.status not in ENDED for it in ended):
            return None
        begun = [(datetime.fromisoformat(it.started).timestamp(), it.seconds) for it in ended if it.started]
        busy, until = 0.0, -np.inf  # several may train at once, and nobody may train between two runs
        for start, seconds in sorted(begun):
            busy, until = busy + max(start + seconds - max(start, until), 0.0), max(until, start + seconds)
        return busy / max(len(begun), 1)

    @cached_property
    def budget(self) -> int | None:
        """How many trainings may be spent; None as long as nobody knows how many the time is enough for."""
        if not self.terms.seconds:
            return self.terms.budget
        if self.per_training is None:
            return None
        return min(self.terms.budget, int(self.terms.seconds / max(self.per_training, 1e-3)))

    @property
    def _fewest(self) -> int:
        return fewest(self.terms.asked, len(self._seen.groups))

    @cached_property
    def schedule(self) -> Schedule | None:
        """How the budget is spent; None where it is not known yet, or too small."""
        if self.budget is None or self.budget < self._fewest:
            return None
        return schedule_of(self.terms.asked, self.budget, len(self._seen.groups))

    @cached_property
    def halving(self) -> Halving:
        """How far the candidates went."""
        if self.schedule is None:
            return Halving((), self.candidates, False)
        of_place = {it.group: it for it in self.trainings}
        found = [self._values(group, of_place.get(group)) for group in self.places]
        values = {name: np.array([of[name] for of, _ in found]) for name in self.candidates}
        one_by_one = replace(self._seen, looks=range(1, self.schedule.seeds + 1))
        complete = {name: one_by_one.complete(name, self.places) for name in self.candidates}
        return halve(values, self.schedule.rungs, complete, [ends for _, ends in found])

    def _values(self, group: Group, of: Trainings | None) -> tuple[Mapping[str, Float], Bounds]:
        """What decides of each candidate in a place, higher is better, and what it can be."""
        assert self.schedule is not None
        ends, values = UNBOUNDED, dict[str, Float]()
        for name in self.candidates:
            values[name] = np.full(self.schedule.seeds, np.nan)
            for at, cell in enumerate(self._cells(group, name)[: self.schedule.seeds]):
                run = of.runs.get((name, cell.seed)) if of else None
                told = _decides(of, run) if of and run else None
                if told is not None:
                    values[name][at], ends = told
        return values, ends

    @cached_property
    def _fresh(self) -> dict[tuple[Group, str], list[Cell]]:
        """The new cells of the one that went furthest, and of the baseline; empty before it is known."""
        winner = self.halving.furthest
        if winner is None or self.schedule is None:
            return {}
        found = dict[tuple[Group, str], list[Cell]]()
        for group in self.places:
            own = self._cells(group, self.baseline)
            later = self._cells(group, winner)[-len(own) :] if own else []  # both have equally many new ones planned
            found |= {
                (group, name): cells[: self.schedule.fresh] for name, cells in ((self.baseline, own), (winner, later))
            }
        return found

    @cached_property
    def needed(self) -> frozenset[Cell]:
        """The cells that are known to be needed, those that have ended too."""
        if self.budget is None or self.schedule is None:
            seeds = [(self.candidates, 1)]
        else:
            went = [*map(tuple, self.halving.means), self.halving.left]
            seeds = [(names, rung.seeds) for names, rung in zip(went, self.schedule.rungs, strict=False)]
        chosen = (
            cell
            for names, count in seeds
            for name in names
            for group in self.places
            for cell in self._cells(group, name)[:count]
        )
        return frozenset([*chosen, *(cell for cells in self._fresh.values() for cell in cells)])

    @property
    def next(self) -> list[Cell]:
        """The cells that an answer waits for now, in the order of the plan; those that failed are tried again."""
        return [it.cell for it in self.manifests if it.cell in self.needed and it.status != "done"]

    @cached_property
    def is_over(self) -> bool:
        """Whether everything has ended that was needed; a budget that is too small ends it too."""
        left = any(it.status not in ENDED for it in self.manifests if it.cell in self.needed)
        return not left and (bool(self._fresh) or self.is_short)

    @property
    def is_short(self) -> bool:
        """Whether the time is too short for the fewest trainings that could tell anything."""
        return self.budget is not None and self.budget < self._fewest

    @property
    def most_left(self) -> int:
        """How many trainings there can be at most until everything is over."""
        if self.is_over:
            return 0
        ended = sum(it.status in ENDED for it in self.manifests if it.cell in self.needed)
        whole = self.terms.budget if self.schedule is None else self.schedule.trainings(len(self.places))
        return max(whole - ended, 0)

    @cached_property
    def not_needed(self) -> frozenset[Cell]:
        """The pending cells that no answer waits for. Before one went furthest any may be needed."""
        pending = frozenset(it.cell for it in self.manifests if it.status == "pending")
        if not (self._fresh or self.is_short):
            went = {name for means in self.halving.means for name in means}.difference(self.halving.left)
            return frozenset(it for it in pending if it.reward.label in went)
        return pending - self.needed

    @property
    def spent(self) -> int:
        """How many trainings choosing took."""
        return len(self.needed) - len(self.fresh)

    @property
    def fresh(self) -> list[Manifest]:
        """How the new trainings ended."""
        there = {cell for cells in self._fresh.values() for cell in cells}
        return [it for it in self.manifests if it.cell in there]

    def compared(self, asked: Iterable[tuple[Trainings, Match]]) -> list[tuple[Trainings, Match]]:
        """The comparison of the one that went furthest with the baseline, by their new trainings alone."""
        winner, found = self.halving.furthest, list[tuple[Trainings, Match]]()
        for of, match in asked:
            if (match.baseline, match.proposed) == (self.baseline, winner):
                one, other = (
                    {cell.seed: side[cell.seed] for cell in self._fresh.get((of.group, name), ()) if cell.seed in side}
                    for name, side in ((match.baseline, match.one), (match.proposed, match.other))
                )
                found.append((of, replace(match, one=one, other=other)))
        return found

    @property
    def text(self) -> str:
        """How it stands, in a line."""
        if self.is_short:
            minutes = -(-self._fewest * (self.per_training or 0.0) // 60)
            return (
                f"{self.terms.seconds / 60:g} minutes are enough for {self.budget} trainings, and {self._fewest} are "
                f"the fewest that can tell anything. The same command with --budget {minutes:.0f}min goes on"
            )
        left = "" if self.is_over else f", at most {self.most_left} trainings left"
        winner = self.halving.furthest
        if winner is not None:
            fresh = f"{sum(it.status in ENDED for it in self.fresh)} of {len(self.fresh)}"
            return f"furthest went {winner}: {fresh} new trainings have ended{left}"
        return f"{len(self.halving.left)} of {len(self.candidates)} candidates are left{left}"

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        rungs, fresh = self.schedule or ((), None)
        return {**super().to_json(), "rungs": to_plain(rungs), "fresh": fresh}


def _decides(of: Trainings, run: Trained) -> tuple[float, Bounds] | None:
    """What decides of a training, higher is better, and what it can be; None where it has no value."""
    name = next(iter(of.deciding), "")
    if name not in of.names:
        return None
    last, episodes = of.last_of(run), run.measured.episodes
    manner = LAST if name in last else of.decided_in(episodes) or deciding_manner(of.group.deterministic, episodes)
    value = (last if name in last else run.measured.manners.get(manner, {})).get(name)
    if value is None:
        return None
    measure = of.quantity(name, manner, max(episodes.values(), default=1))
    low, high = measure.ends
    return (-value, (-high, -low)) if measure.better == "lower" else (value, (low, high))
