"""At which look each training of an experiment was done, and which looks are complete."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from harness.record.cell import Cell
from harness.record.manifest import Manifest
from harness.results.comparison import Comparison, Group

ENDED = ("done", "failed", "damaged", "skipped")


@dataclass(frozen=True, eq=False)
class Seen:
    """The trainings of an experiment that a plan divides into looks.

    The seeds of a place come in the order of the plan: those of the first look first.

    Attributes:
        looks: Seeds of each reward in each place at each look, increasing.
        status: How each cell ended, by group and reward, in the order of the plan.
    """

    looks: Sequence[int]
    status: Mapping[tuple[Group, str], Mapping[Cell, str]]

    @classmethod
    def of(cls, manifests: Sequence[Manifest], looks: Sequence[int]) -> "Seen":
        """What manifests tell, in the order of the plan."""
        found: dict[tuple[Group, str], dict[Cell, str]] = {}
        for it in manifests:
            found.setdefault((Group.of(it.cell), it.cell.reward.label), {})[it.cell] = it.status
        return cls(looks, found)

    @property
    def to_come(self) -> int:
        """How many trainings have not ended yet."""
        return sum(status not in ENDED for cells in self.status.values() for status in cells.values())

    @property
    def groups(self) -> tuple[Group, ...]:
        """The places."""
        return tuple(dict.fromkeys(group for group, _ in self.status))

    def look_of(self, comparison: Comparison) -> tuple[Mapping[int, int], int]:
        """The look of each seed, counted from 0, and how many looks are complete under both rewards."""
        cells = self.status.get((comparison.group, comparison.baseline), {})
        of_seed = {cell.seed: sum(at >= end for end in self.looks) for at, cell in enumerate(cells)}
        rewards = (comparison.baseline, comparison.proposed)
        return of_seed, min(self.complete(reward, [comparison.group]) for reward in rewards)

    def complete(self, reward: str, groups: Iterable[Group] | None = None) -> int:
        """How many looks are complete for a reward: all of their cells have ended, in all places."""
        there = [self.status.get((group, reward), {}) for group in (self.groups if groups is None else groups)]
        ended = [_ended_in_order(cells.values()) for cells in there]
        return sum(min(ended, default=0) >= end for end in self.looks)

    def cells_of(self, rewards: Iterable[str], look: int) -> list[Cell]:
        """The cells of some rewards up to a look, counted from 0, in the order of the plan within each place."""
        wanted = set(rewards)
        return [
            cell
            for (_, reward), cells in self.status.items()
            if reward in wanted
            for cell in list(cells)[: self.looks[look]]
        ]


def _ended_in_order(statuses: Iterable[str]) -> int:
    """How many cells from the first on have ended."""
    count = 0
    for status in statuses:
        if status not in ENDED:
            break
        count += 1
    return count
