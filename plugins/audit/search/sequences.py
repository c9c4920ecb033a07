"""An evolution of whole action sequences, beside each other for every start: what is paid, what succeeds, what is new.

Several archives breed: best-paid failures and best-paid successes under both sums of pay, the fastest successes, and,
until success is met, what came nearest or went where nothing else did. The last part of a budget breeds for successes
alone, so that a failure is not called better paid only because successes were searched less.
"""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from harness import Float, Ints, Mask
from harness.experiment.environments.spaces import rows_of

from .kept import Cells, Kept, Way
from .linear import LARGEST
from .moves import Feedback, draw_feedback, moves_in
from .mutations import Pairs, mutations_of
from .world import Actions, Data, Outcomes, Rng, World

FAILURES, FAILURES_LATER, SUCCESSES, SUCCESSES_LATER, FASTEST, NEAREST = (
    "failures", "failures discounted", "successes", "successes discounted", "fastest", "nearest"
)  # fmt: skip
CELLS, FRESH = "cells", "fresh"
"""Also parents: how somewhere new was reached, and nobody."""
MANY, FEWER = 12, 6
"""How many an archive keeps."""
GENERATIONS, FEWEST_GENERATIONS = 100, 20
"""A budget is shared among so many generations where a world plays one episode at a time; among fewer, down to so
many, where it plays many side by side."""
FINISHING = 0.3
"""The share of a budget, the last, that breeds for successes alone."""
Weights = Mapping[str, float]
SEEKING: Weights = {FAILURES: 3, FAILURES_LATER: 1, NEAREST: 4, CELLS: 4, FRESH: 1.5}
"""How often each archive breeds while no success of the start is known."""
WEIGHING: Weights = {
    FAILURES: 4, FAILURES_LATER: 1.5, SUCCESSES: 3, SUCCESSES_LATER: 1.5,
    FASTEST: 2, NEAREST: 0.5, CELLS: 1, FRESH: 0.5,
}  # fmt: skip
"""How often once one is."""
SUCCEEDING: Weights = {FAILURES: 2, FAILURES_LATER: 0.5, SUCCESSES: 5, SUCCESSES_LATER: 2, FASTEST: 2.5, FRESH: 0.2}
"""How often in the last part."""


PROVED = 40
"""So many of the latest feedbacks that an archive kept are tried again, at other starts too."""
TWICE = 0.25
"""The share of children that are mutated twice."""


class Archive:
    """The best sequences of one start, by one score, none of them twice.

    Attributes:
        ways: The sequences, the best first.
    """

    def __init__(self, room: int) -> None:
        """Keep nothing yet; `room` is how many it keeps."""
        self.room, self.ways, self._scores = room, list[Way](), np.zeros(0)

    def offer(self, ways: Sequence[Way], scores: Float) -> Mask:
        """Keep the best of these and those, larger scores are better; says which of these were kept, (n,)."""
        if not ways:
            return np.zeros(0, bool)
        every, score = [*self.ways, *ways], np.concatenate([self._scores, scores])
        unit = 1e-6 * max(float(np.abs(score).max()), 1e-9)  # scores that differ by less are alike
        alike = list(zip(np.round(score / unit).tolist(), (it.length for it in every), strict=True))
        first: dict[tuple[float, int], int] = {}
        for place in np.argsort(-score, kind="stable").tolist():
            first.setdefault(alike[place], place)
        best = [*first.values()][: self.room]
        kept = np.isin(np.arange(len(self.ways), len(every)), best)
        if kept.any():
            self.ways, self._scores = [every[it] for it in best], score[best]
        return kept

    def draw(self, rng: Rng, count: int) -> list[Way]:
        """Some of them, the better the more often."""
        return [self.ways[it] for it in (len(self.ways) * rng.random(count) ** 1.5).astype(np.int64)]


@dataclass(eq=False)
class Evolution:
    """The archives of all starts, and which mutations have proved useful.

    Attributes:
        world: Where it plays.
        kept: Gets every episode.
        rng: Draws everything.
    """

    world: World
    kept: Kept
    rng: Rng

    def __post_init__(self) -> None:
        self._moves = moves_in(self.world.space)
        self._mutations = mutations_of(self._moves)
        rooms = {FAILURES: MANY, SUCCESSES: MANY, FASTEST: FEWER, NEAREST: FEWER}
        if self.world.gamma < 1.0:
            rooms |= {FAILURES_LATER: FEWER, SUCCESSES_LATER: FEWER}
        self._archives = [{name: Archive(room) for name, room in rooms.items()} for _ in self.kept.starts]
        self._cells = [Cells(self.world.observes) for _ in self.kept.starts]
        self._spread: Float = np.zeros(0)  # of observations; none where sequences do not hold
        self._proved: list[Feedback] = []
        # children that an archive kept, and children: by mutation; of those that hold, and of those that do not
        self._useful, self._held = np.ones((2, len(self._mutations))), np.ones((2, 2))

    def _play(self, rows: Ints, genes: Actions, holds: Sequence[Feedback | None]) -> tuple[Outcomes, Mask]:
        """Play sequences, (n, horizon, ...), each at the start of a row; also says which an archive kept, (n,)."""
        actions = self._moves.played(genes)
        outcomes = self.world.play(self.kept.starts[rows], actions)
        self.kept.add(rows, actions, outcomes, "search")
        return outcomes, self._file(rows, genes, outcomes, holds)

    def take(
        self,
        rows: Ints,
        actions: Sequence[Actions],
        outcomes: Outcomes,
        made_by: str,
        policies: Sequence[Data | None] = (),
        hold: Feedback | None = None,
    ) -> bool:
        """Keep episodes that others have played, and breed from them, see `Kept.add`; says whether an archive did."""
        self.kept.add(rows, actions, outcomes, made_by, policies)
        genes = [self._moves.written(self.filled(it)) for it in actions]
        return bool(self._file(rows, genes, outcomes, [hold] * len(rows)).any())

    def filled(self, actions: Actions) -> Actions:
        """What an episode of the world took, (steps, ...), as long as the horizon: noise follows it."""
        rest = self._moves.played(self._moves.coloured(self.rng, 1, self.world.horizon)[0])
        short = np.asarray(actions, rest.dtype)[: len(rest)]
        return np.concatenate([short.reshape(len(short), *rest.shape[1:]), rest[len(short) :]])

    def random(self, rounds: int) -> list[list[float]]:
        """Random actions at every start, and noise: medians of what the first are paid, and discounted, by start."""
        count, steps = len(self.kept.starts), self.world.horizon
        colours = [self._moves.white] * rounds + [self._moves.coloured] * rounds
        genes = np.concatenate([colour(self.rng, count, steps) for colour in colours])
        outcomes, _ = self._play(np.tile(np.arange(count), len(colours)), genes, [None] * len(genes))
        seen = outcomes.trails
        if seen and seen[0].shape[1] <= LARGEST and self.world.together == 1:
            self._spread = np.maximum(np.concatenate(seen).std(axis=0), 1e-3)
        paid = np.stack([outcomes.paid, outcomes.discounted]).reshape(2, -1, count)
        typical: list[list[float]] = np.median(paid[:, :rounds], axis=1).tolist()
        return typical

    def generation(self, children: int, ending: bool) -> None:
        """Breed and play so many children of each start."""
        rows, rng = np.repeat(np.arange(len(self.kept.starts)), children), self.rng
        families = [self._parents(row, children, ending) for row in range(len(self.kept.starts))]
        first, second, is_free = (list(itertools.chain(*parts)) for parts in zip(*families, strict=True))
        rates = self._useful[0] / self._useful[1]
        chances = 0.4 / len(rates) + 0.6 * rates / rates.sum()
        chosen = np.where(is_free, -1, rng.choice(len(rates), len(rows), p=chances))
        # each child by its mutation and a quarter of them by a second one; those without any are as their parent is
        genes = np.stack([it.genes for it in first])
        twice = (chosen >= 0) & (rng.random(len(genes)) < TWICE)
        again = rng.integers(len(self._mutations), size=len(genes))
        for wanted in (chosen, np.where(twice, again, -1)):
            for which, mutation in enumerate(self._mutations):
                if at := np.flatnonzero(wanted == which).tolist():
                    lengths, others = np.array([first[k].length for k in at]), [second[k] for k in at]
                    parts, other_lengths = np.stack([it.genes for it in others]), np.array([it.length for it in others])
                    genes[at] = mutation(Pairs(self._moves, rng, genes[at], lengths, parts, other_lengths))
        rates = self._held[0] / self._held[1]
        share = float(np.clip(rates[0] / rates.sum(), 0.1, 0.6)) if len(self._spread) else 0.0
        holding = rng.random(len(rows)) < share
        entered = np.zeros(len(rows), bool)
        if not holding.all():
            free = np.flatnonzero(~holding)
            _, entered[free] = self._play(rows[free], genes[free], [first[k].hold for k in free])
        for k in np.flatnonzero(holding):
            length = max(1, first[k].length)
            entered[k] = self._hold(
                rows[[k]], genes[k], first[k].hold, length if is_free[k] else int(rng.integers(length))
            )
        for which in range(len(chances)):
            these = (chosen == which) & ~holding
            self._useful[:, which] += entered[these].sum(), these.sum()
        for which, these in enumerate((holding, ~holding)):
            self._held[:, which] += entered[these].sum(), these.sum()
        self._useful *= 0.99
        self._held *= 0.99

    def _hold(self, row: Ints, genes: Actions, known: Feedback | None, step: int) -> bool:
        """Play a sequence that holds: as its parent did, changed a little; or from a step on as another, or anyhow."""
        rng, chance, flat = self.rng, self.rng.random(), rows_of(self.world.observes).of
        if known is not None and chance < 0.6:
            held = known.changed(rng, step)
        elif self._proved and chance < 0.85:
            held = replace(self._proved[rng.integers(len(self._proved))], step=step)
        else:
            held = draw_feedback(rng, self._moves, self._spread, step)
        policy = held.after(self._moves.played(genes), self._moves, lambda seen: np.asarray(flat(seen), np.float32))
        outcomes, taken = self.world.act(self.kept.starts[row], policy)
        is_kept = self.take(row, taken, outcomes, "search", hold=held)
        if is_kept:
            self._proved = [*self._proved[1 - PROVED :], held]
        return is_kept

    def _parents(self, row: int, count: int, ending: bool) -> tuple[list[Way], list[Way], Sequence[bool]]:
        """Parents of the children of one start: who is changed, whose parts may be put in; and who is to be left."""
        known: dict[str, Archive | Cells] = {**self._archives[row], CELLS: self._cells[row]}
        rng, horizon, weights = self.rng, self.world.horizon, SUCCEEDING if ending else WEIGHING
        if not known[SUCCESSES].ways:
            weights = SEEKING
        able = [name for name in weights if name == FRESH or (name in known and known[name].ways)]
        shares = np.array([weights[name] for name in able])
        best = self.kept.plain[row]
        if ending and best.failure_pay > best.success_pay:
            shares[able.index(FAILURES)] *= 3.0
        names = rng.choice(len(able), count, p=shares / shares.sum())
        first = [Way(genes) for genes in self._moves.coloured(rng, count, horizon)]
        for place, name in enumerate(able):
            these = np.flatnonzero(names == place).tolist()
            if these and name in known:
                for k, way in zip(these, known[name].draw(rng, len(these)), strict=True):
                    until = way.length if name == CELLS else horizon  # noise follows a way to a cell
                    first[k] = way._replace(genes=np.concatenate([way.genes[:until], first[k].genes[until:]]))
        # the other parents: successes and failures of the start as often, some of another start
        rows = np.where(rng.random(count) < 0.1, rng.integers(len(self.kept.starts), size=count), row)
        kinds = rng.integers(2, size=count)
        second = [Way(genes, horizon) for genes in self._moves.coloured(rng, count, horizon)]
        for at, kind in {(int(at), int(kind)) for at, kind in zip(rows, kinds, strict=True)}:
            these = np.flatnonzero((rows == at) & (kinds == kind)).tolist()
            archive = self._archives[at][(FAILURES, SUCCESSES)[kind]]
            if archive.ways:
                for k, way in zip(these, archive.draw(rng, len(these)), strict=True):
                    second[k] = way
        return first, second, [able[name] in (CELLS, FRESH) for name in names]

    def _file(
        self, rows: Ints, genes: Sequence[Actions] | Actions, outcomes: Outcomes, holds: Sequence[Feedback | None]
    ) -> Mask:
        """Offer episodes to the archives and the cells; says which an archive kept, (n,)."""
        entered = np.zeros(len(rows), bool)
        ways = list(map(Way, genes, outcomes.steps.tolist(), holds))
        scores = {
            FAILURES: (outcomes.paid, ~outcomes.success),
            FAILURES_LATER: (outcomes.discounted, ~outcomes.success),
            SUCCESSES: (outcomes.paid, outcomes.success),
            SUCCESSES_LATER: (outcomes.discounted, outcomes.success),
            FASTEST: (np.arctan(outcomes.paid) / np.pi - outcomes.time, outcomes.success),
            NEAREST: (outcomes.near, ~outcomes.success),
        }
        for row in np.unique(rows):
            for name, archive in self._archives[row].items():
                score, chosen = scores[name]
                these = np.flatnonzero((rows == row) & chosen & np.isfinite(score))
                entered[these] |= archive.offer([ways[k] for k in these], score[these])
        for k, trail in enumerate(outcomes.trails):
            self._cells[rows[k]].add(trail, genes[k])
        return entered


def evolve(evolution: Evolution, budget: int) -> list[float]:
    """Spend a budget of steps; returns by how much the best-paid success of each start rose in the last fifth of it."""
    world, starts = evolution.world, len(evolution.kept.starts)
    begun = world.taken
    wide = budget // world.horizon
    children = max(1, max(wide // GENERATIONS, min(world.together, wide // FEWEST_GENERATIONS)) // starts)
    before: list[float] | None = None
    while (spent := world.taken - begun) + starts * world.horizon <= budget:
        if before is None and spent >= 0.8 * budget:
            before = [it.success_pay for it in evolution.kept.plain]
        left = max(1, (budget - spent) // (starts * world.horizon))
        evolution.generation(min(children, left), ending=spent >= (1.0 - FINISHING) * budget)
    after = [it.success_pay for it in evolution.kept.plain]
    return [0.0 if now == -np.inf else now - was for was, now in zip(before or after, after, strict=True)]
