"""An evolution of whole action sequences, beside each other for every start: what is paid, what succeeds, what is new.

Several archives breed: best-paid failures and best-paid successes under both sums of pay, the fastest successes, and,
until success is met, what came nearest or went where nothing else did. The last part of a budget breeds for successes
alone, so that a failure is not called better paid only because successes were searched less.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness import Float, Ints
from harness.experiment.environments.spaces import rows_of

from .kept import Cells, Kept
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
Holds = NDArray[np.object_]
"""By what each of some sequences held: a `Feedback`, or None."""
SEEKING: Weights = {FAILURES: 3, FAILURES_LATER: 1, NEAREST: 4, CELLS: 4, FRESH: 1.5}
"""How often each archive breeds while no success of the start is known."""
WEIGHING: Weights = {
    FAILURES: 4, FAILURES_LATER: 1.5, SUCCESSES: 3, SUCCESSES_LATER: 1.5,
    FASTEST: 2, NEAREST: 0.5, CELLS: 1, FRESH: 0.5,
}  # fmt: skip
"""How often once one is."""
SUCCEEDING: Weights = {FAILURES: 2, FAILURES_LATER: 0.5, SUCCESSES: 5, SUCCESSES_LATER: 2, FASTEST: 2.5, FRESH: 0.2}
"""How often in the last part."""


MOST_SEEN = 64
"""Numbers of an observation; where there are more, no sequence holds by them."""
PROVED = 40
"""So many of the latest feedbacks that an archive kept are tried again, at other starts too."""
TWICE = 0.25
"""The share of children that are mutated twice."""


@dataclass(eq=False)
class Archive:
    """The best sequences of one start, by one score, none of them twice.

    Attributes:
        room: How many it keeps.
        genes: The sequences, the best first, (n, horizon, ...).
        length: How long their episodes were, (n,).
        score: Larger is better, (n,).
        holds: By what each of them held, if it did, (n,).
    """

    room: int
    genes: Actions
    length: Ints = field(default_factory=lambda: np.zeros(0, np.int64))
    score: Float = field(default_factory=lambda: np.zeros(0))
    holds: Holds = field(default_factory=lambda: np.zeros(0, object))

    def __len__(self) -> int:
        return len(self.length)

    def offer(self, genes: Actions, length: Ints, score: Float, holds: Holds) -> NDArray[Any]:
        """Keep the best of these and those; says which of these were kept, (n,)."""
        if not len(length):
            return np.zeros(0, bool)
        known = len(self)
        every = (self.genes, genes), (self.length, length), (self.score, score), (self.holds, holds)
        genes, length, score, holds = map(np.concatenate, every)
        unit = 1e-6 * max(float(np.abs(score).max()), 1e-9)  # scores that differ by less are alike
        alike = list(zip(np.round(score / unit).tolist(), length.tolist(), strict=True))
        first: dict[tuple[float, int], int] = {}
        for place in np.argsort(-score, kind="stable").tolist():
            first.setdefault(alike[place], place)
        best = [*first.values()][: self.room]
        kept = np.isin(np.arange(known, len(score)), best)
        if kept.any():
            self.genes, self.length, self.score, self.holds = genes[best], length[best], score[best], holds[best]
        return kept


class Evolution:
    """The archives of all starts, and which mutations have proved useful.

    Attributes:
        world: Where it plays.
        kept: Gets every episode.
    """

    def __init__(self, world: World, kept: Kept, rng: Rng) -> None:
        self.world, self.kept = world, kept
        self._rng, self._moves = rng, moves_in(world.space)
        self._mutations = mutations_of(self._moves)
        self._useful = np.ones((2, len(self._mutations)))  # children that an archive kept, children
        none = self._moves.white(np.random.default_rng(0), 0, world.horizon)
        rooms = {FAILURES: MANY, SUCCESSES: MANY, FASTEST: FEWER, NEAREST: FEWER}
        if world.gamma < 1.0:
            rooms |= {FAILURES_LATER: FEWER, SUCCESSES_LATER: FEWER}
        self._archives = [{name: Archive(room, none) for name, room in rooms.items()} for _ in kept.starts]
        self._cells = [Cells(world.observes) for _ in kept.starts]
        self._spread: Float = np.zeros(0)  # of observations; none where sequences do not hold
        self._proved: list[Feedback] = []
        self._held = np.ones((2, 2))  # the same of children that hold, and of those that do not

    def play(self, rows: Ints, genes: Actions, holds: Holds) -> tuple[Outcomes, NDArray[Any]]:
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
    ) -> None:
        """Keep episodes that others have played, and breed from them; see `Kept.add`."""
        self.kept.add(rows, actions, outcomes, made_by, policies)
        genes = np.stack([self._moves.written(self.filled(it)) for it in actions])
        self._file(rows, genes, outcomes, np.full(len(rows), None))

    def filled(self, actions: Actions) -> Actions:
        """What an episode of the world took, (steps, ...), as long as the horizon: noise follows it."""
        rest = self._moves.played(self._moves.coloured(self._rng, 1, self.world.horizon)[0])
        short = np.asarray(actions, rest.dtype)[: len(rest)]
        return np.concatenate([short.reshape(len(short), *rest.shape[1:]), rest[len(short) :]])

    def random(self, rounds: int) -> list[list[float]]:
        """Random actions at every start, and noise: medians of what the first are paid, and discounted, by start."""
        count, steps = len(self.kept.starts), self.world.horizon
        colours = [self._moves.white] * rounds + [self._moves.coloured] * rounds
        genes = np.concatenate([colour(self._rng, count, steps) for colour in colours])
        outcomes, _ = self.play(np.tile(np.arange(count), len(colours)), genes, np.full(len(genes), None))
        seen = outcomes.trails
        if seen and seen[0].shape[1] <= MOST_SEEN and self.world.together == 1:
            self._spread = np.maximum(np.concatenate(seen).std(axis=0), 1e-3)
        paid = np.stack([outcomes.paid, outcomes.discounted]).reshape(2, -1, count)
        typical: list[list[float]] = np.median(paid[:, :rounds], axis=1).tolist()
        return typical

    def generation(self, children: int, ending: bool) -> None:
        """Breed and play so many children of each start."""
        rows = np.repeat(np.arange(len(self.kept.starts)), children)
        families = [self._parents(row, children, ending) for row in range(len(self.kept.starts))]
        pairs = Pairs(
            self._moves, self._rng, *(np.concatenate(part) for part in zip(*(it[0] for it in families), strict=True))
        )
        free, holds = (np.concatenate([it[which] for it in families]) for which in (1, 2))
        rates = self._useful[0] / self._useful[1]
        chances = 0.4 / len(rates) + 0.6 * rates / rates.sum()
        chosen = np.where(free, -1, self._rng.choice(len(rates), len(rows), p=chances))
        genes = self._mutated(pairs, chosen)
        rates = self._held[0] / self._held[1]
        share = float(np.clip(rates[0] / rates.sum(), 0.1, 0.6)) if len(self._spread) else 0.0
        holding = self._rng.random(len(rows)) < share
        entered = np.zeros(len(rows), bool)
        if not holding.all():
            _, entered[~holding] = self.play(rows[~holding], genes[~holding], holds[~holding])
        for k in np.flatnonzero(holding):
            length = max(1, int(pairs.length[k]))
            entered[k] = self._hold(
                rows[[k]], genes[k], holds[k], length if free[k] else int(self._rng.integers(length))
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
        rng, chance, flat = self._rng, self._rng.random(), rows_of(self.world.observes).of
        if known is not None and chance < 0.6:
            held = known.changed(rng, step)
        elif self._proved and chance < 0.85:
            held = replace(self._proved[rng.integers(len(self._proved))], step=step)
        else:
            held = draw_feedback(rng, self._moves, self._spread, step)
        policy = held.after(self._moves.played(genes), self._moves, lambda seen: np.asarray(flat(seen), np.float32))
        outcomes, taken = self.world.act(self.kept.starts[row], policy)
        self.kept.add(row, taken, outcomes, "search")
        filled = self._moves.written(self.filled(taken[0]))[np.newaxis]
        is_kept = bool(self._file(row, filled, outcomes, np.array([held], object))[0])
        if is_kept:
            self._proved = [*self._proved[1 - PROVED :], held]
        return is_kept

    def _parents(self, row: int, count: int, ending: bool) -> tuple[tuple[Any, ...], NDArray[Any], NDArray[Any]]:
        """Pairs for the children of one start, as `Pairs` takes them; which are to be left; what the first held."""
        archives, rng = self._archives[row], self._rng
        weights = SUCCEEDING if ending else WEIGHING
        if not len(archives[SUCCESSES]):
            weights = SEEKING
        sizes = {name: len(it) for name, it in archives.items()} | {CELLS: len(self._cells[row]), FRESH: 1}
        able = [name for name in weights if sizes.get(name)]
        shares = np.array([weights[name] for name in able])
        best = self.kept.plain[row]
        if ending and best.failure_pay > best.success_pay:
            shares[able.index(FAILURES)] *= 3.0
        names = rng.choice(len(able), count, p=shares / shares.sum())
        first = self._moves.coloured(rng, count, self.world.horizon)
        length, holds = np.zeros(count, np.int64), np.full(count, None)
        for place, name in enumerate(able):
            these = np.flatnonzero(names == place)
            if name in archives:
                first[these], length[these], holds[these] = self._drawn(archives[name], len(these))
            elif name == CELLS and len(these):
                ways, steps = self._cells[row].draw(rng, len(these))
                before = np.arange(self.world.horizon) < steps[:, None]
                shape = before.reshape(*before.shape, *(1,) * (first.ndim - 2))
                first[these], length[these] = np.where(shape, np.stack(ways), first[these]), steps
        # the other parents: successes and failures of the start as often, some of another start
        rows = np.where(rng.random(count) < 0.1, rng.integers(len(self.kept.starts), size=count), row)
        kinds = rng.integers(2, size=count)
        second = self._moves.coloured(rng, count, self.world.horizon)
        second_length = np.full(count, self.world.horizon)
        for at, kind in {(int(at), int(kind)) for at, kind in zip(rows, kinds, strict=True)}:
            these = np.flatnonzero((rows == at) & (kinds == kind))
            archive = self._archives[at][(FAILURES, SUCCESSES)[kind]]
            if len(archive):
                second[these], second_length[these], _ = self._drawn(archive, len(these))
        is_free = np.isin(names, [place for place, name in enumerate(able) if name in (CELLS, FRESH)])
        return (first, length, second, second_length), is_free, holds

    def _drawn(self, archive: Archive, count: int) -> tuple[Actions, Ints, Holds]:
        """Members of an archive, the better the more often."""
        places = (len(archive) * self._rng.random(count) ** 1.5).astype(np.int64)
        return archive.genes[places], archive.length[places], archive.holds[places]

    def _mutated(self, pairs: Pairs, chosen: NDArray[Any]) -> Actions:
        """Children, each by its mutation and a quarter of them by a second one; those without any are as they are."""
        genes = pairs.first.copy()
        twice = (chosen >= 0) & (self._rng.random(len(pairs)) < TWICE)
        again = self._rng.integers(len(self._mutations), size=len(pairs))
        for wanted in (chosen, np.where(twice, again, -1)):
            for which, mutation in enumerate(self._mutations):
                these = np.flatnonzero(wanted == which)
                if len(these):
                    of = pairs.of(these)
                    genes[these] = mutation(replace(of, first=genes[these]))
        return genes

    def _file(self, rows: Ints, genes: Actions, outcomes: Outcomes, holds: Holds) -> NDArray[Any]:
        """Offer episodes to the archives and the cells; says which an archive kept, (n,)."""
        entered = np.zeros(len(rows), bool)
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
                entered[these] |= archive.offer(genes[these], outcomes.steps[these], score[these], holds[these])
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
