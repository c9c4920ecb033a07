"""Pairs of evaluation episodes that began alike, one under each reward, counted by how both ended."""

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from harness.log.log import SUCCESS
from harness.record.cell import Cell
from harness.results.comparison import Comparison, Group
from harness.results.recordings.episodes import Episodes
from harness.results.recordings.runs import Run
from harness.results.results import Results

READ = 200
"""How many episodes of an evaluation are looked at."""
BOTH, FIRST, SECOND, NEITHER = range(4)
"""Kinds of pairs of episodes that succeed or not; `kinds_of` has their words in this order."""


class Met(NamedTuple):
    """An episode that both policies began alike."""

    seed: int
    number: int
    """From 0."""
    kind: int
    """How both ended: the place of its words in `Pairs.kinds`."""
    differs: float
    """The proposed reward's less the baseline's: of how long both took, or of what tells the kinds apart."""


@dataclass(frozen=True)
class Pairs:
    """All pairs of a comparison, at least one.

    Attributes:
        kinds: In words, how both can end.
        met: The pairs, by seed and then by number.
    """

    kinds: tuple[str, ...]
    met: tuple[Met, ...]

    @cached_property
    def counts(self) -> dict[int, int]:
        """How many pairs are of each kind that occurs, the most frequent one first."""
        return dict(sorted(Counter(it.kind for it in self.met).items(), key=lambda it: (-it[1], it[0])))

    @property
    def usual(self) -> int:
        """The most frequent kind."""
        return next(iter(self.counts))

    def typical(self, kind: int) -> int:
        """The place of the pair that stands for its kind: the middle one by how much both differ."""
        of_kind = [place for place, it in enumerate(self.met) if it.kind == kind]
        return sorted(of_kind, key=lambda place: (self.met[place].differs, place))[(len(of_kind) - 1) // 2]

    def share(self, kind: int) -> str:
        """How often it occurs, in words: ``both reach: 576 of 600 pairs``."""
        return f"{self.kinds[kind]}: {self.counts[kind]:,} of {len(self.met):,} pairs"

    @property
    def otherwise(self) -> str:
        """How many pairs are of another kind than the most frequent one; empty where none is."""
        count = len(self.met) - self.counts[self.usual]
        return f"{count:,} of {len(self.met):,} end otherwise" if count else ""


def kinds_of(verb: str, proposed: str, ending: str = "s") -> tuple[str, ...]:
    """How both can end, where each succeeds or not.

    Args:
        verb: What success is, ``reach``.
        proposed: The label of the proposed reward.
        ending: What the verb ends in, of one.
    """
    one = f"{verb}{ending}"
    return f"both {verb}", f"only the baseline {one}", f"only {proposed} {one}", f"neither {one}"


def kind_of(first: bool, second: bool) -> int:
    """The kind of a pair of which the baseline's succeeds or not, and the proposed reward's."""
    return (BOTH, FIRST, SECOND, NEITHER)[2 * (not first) + (not second)]


def cells_by_seed(results: Results, comparison: Comparison) -> tuple[tuple[Cell, ...], tuple[Cell, ...]]:
    """The cells of both rewards, of the seeds that both have; none where one of them is not done."""
    found = {(Group.of(cell), cell.reward.label, cell.seed): cell for cell in results.done_cells}
    baseline, proposed = (
        tuple(found[key] for seed in comparison.seeds if (key := (comparison.group, reward, seed)) in found)
        for reward in (comparison.baseline, comparison.proposed)
    )
    return (baseline, proposed) if len(baseline) == len(proposed) == len(comparison.seeds) else ((), ())


def environment_pairs(results: Results, comparison: Comparison) -> Pairs | None:
    """The pairs of a comparison in an environment; None where no policy was evaluated, or nothing tells how.

    Where no measure is a success, the first one that decides tells which of both was better.

    Raises:
        SchemaError: A file is damaged or written by a newer version.
    """
    if not results.is_experiment:
        return None
    sides = [
        [run.evaluation.episodes for it in cells if isinstance(run := results.run(it), Run) and run.evaluation]
        for cells in cells_by_seed(results, comparison)
    ]
    wanted = (SUCCESS, *comparison.measured.deciding)
    name = next((it for it in wanted if all(it in of.behaviour for side in sides for of in side)), None)
    if name is None or {*map(len, sides)} != {len(comparison.seeds)}:
        return None
    better = next((it.measure.better for it in comparison.measured.changes if it.name == name), "higher")
    met = [
        _met(seed, number, name, better, *both)
        for seed, *both_of in zip(comparison.seeds, *sides, strict=True)
        for number, both in enumerate(zip(*(_outcomes(of, name) for of in both_of), strict=False))
    ]
    proposed, told = comparison.proposed, name.replace("_", " ")
    words = (f"the same {told} under both", f"the baseline has the better {told}", f"{proposed} has the better {told}")
    kinds = kinds_of("succeed", proposed) if name == SUCCESS else words
    return Pairs(kinds, tuple(met)) if met else None


class ShownPair(NamedTuple):
    """The pair of an environment that stands for a comparison: typical, where the pairs can be told apart."""

    cells: tuple[Cell, Cell]
    number: int
    """Its episode, from 0."""
    pairs: Pairs | None


def shown_pair(results: Results, comparison: Comparison) -> ShownPair | None:
    """The typical pair of the most frequent kind; the first one where nothing tells how an episode came out.

    None where a cell is not done.

    Args:
        results: The experiment.
        comparison: In an environment, with a seed that both rewards have.

    Raises:
        SchemaError: A file is damaged or written by a newer version.
    """
    baseline, proposed = cells_by_seed(results, comparison)
    if not baseline:
        return None
    pairs = environment_pairs(results, comparison)
    if pairs is None:
        return ShownPair((baseline[0], proposed[0]), 0, None)
    it = pairs.met[pairs.typical(pairs.usual)]
    at = comparison.seeds.index(it.seed)
    return ShownPair((baseline[at], proposed[at]), it.number, pairs)


def _outcomes(of: Episodes, name: str) -> list[tuple[int, float]]:
    """How long each of the first episodes took, in steps, and its value of a measure."""
    lengths = np.diff(of.last[:READ], prepend=-1)
    return list(zip(lengths.tolist(), of.behaviour[name][:READ].tolist(), strict=True))


def _met(seed: int, number: int, name: str, better: str, first: tuple[int, float], second: tuple[int, float]) -> Met:
    if name == SUCCESS:
        return Met(seed, number, kind_of(bool(first[1]), bool(second[1])), second[0] - first[0])
    gained = (second[1] - first[1]) * (1.0 if better == "higher" else -1.0)
    return Met(seed, number, SECOND if gained > 0.0 else FIRST if gained < 0.0 else BOTH, gained)
