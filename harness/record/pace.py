"""How long the rest of a run takes, by what its cells took so far."""

import heapq
import math
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import NamedTuple, TypeAlias

from harness.record.cell import Cell, Manifest

Kind: TypeAlias = tuple[str, str]
"""Labels of simulator, or environment, and algorithm: what decides how long a step takes, and how much it leaves."""


def kind_of(cell: Cell) -> Kind:
    """The kind of a cell."""
    return cell.place.label, cell.learner


SETTLING, SHORTEST, WINDOW = 1.0, 1.0, 20.0
"""Seconds: what a training takes at first is not counted, because many act at random before they learn; over how long
its speed is measured at least, and at most."""


class Begun(NamedTuple):
    """How far a cell is that is running."""

    cell: Cell
    steps: int
    per_step: float | None
    """Seconds that a step of its training takes now; None before that is known."""
    since: float = 0.0
    """Seconds since its training ended."""


def took(cell: Cell, training: float, besides: float) -> Manifest:
    """What is known of a done cell that took so long, [s]: training, and before and after it."""
    return Manifest(cell, status="done", training_seconds=training, seconds=training + besides)


def time_left(
    ended: Sequence[Manifest], begun: Sequence[Begun], waiting: Sequence[Cell], at_once: int = 1
) -> float | None:
    """Seconds until all cells have ended, with `at_once` of them at a time, in order; None before a step was measured.

    A kind of which no step was measured counts as the mean of the others. What a cell takes besides its training is
    known once a cell has ended; before that it counts as nothing.
    """
    measured = [(kind_of(it.cell), it.training_seconds, it.cell.steps) for it in ended]
    now = [(kind_of(it.cell), it.per_step, 1) for it in begun if it.per_step is not None]
    if not (measured or now):
        return None
    besides = [(kind_of(it.cell), max(it.seconds - it.training_seconds, 0.0), 1) for it in ended]

    @cache
    def costs(kind: Kind) -> tuple[float, float]:
        return _mean(measured, kind, now), _mean(besides, kind)

    def rest(it: Begun) -> float:
        known, after = costs(kind_of(it.cell))
        per_step = known if it.per_step is None else it.per_step
        return (it.cell.steps - it.steps) * per_step + max(after - it.since, 0.0)

    return makespan([rest(it) for it in begun], [rest(Begun(cell, 0, None)) for cell in waiting], at_once)


def makespan(running: Iterable[float], waiting: Iterable[float], at_once: int) -> float:
    """Seconds until everything has ended, where the next begins as soon as one ends.

    Args:
        running: Seconds that each of those takes yet that have begun.
        waiting: Seconds that each of the others takes, in order.
        at_once: How many are done at a time, at least 1.
    """
    ends = sorted(running)
    ends = [*[0.0] * (at_once - len(ends)), *ends]  # sorted: a heap
    for seconds in waiting:
        heapq.heapreplace(ends, ends[0] + seconds)
    return max(ends)


def _mean(
    values: Sequence[tuple[Kind, float, int]], kind: Kind, others: Sequence[tuple[Kind, float, int]] = ()
) -> float:
    """Seconds per unit of a kind: of its own values, else of the others of the kind, else of all; 0 without any."""
    own = ([it for it in those if it[0] == kind] for those in (values, others))
    _, seconds, units = zip(*next(filter(None, (*own, values, others)), [(kind, 0.0, 1)]), strict=True)
    return float(sum(seconds) / sum(units))


@dataclass
class _Running:
    """A cell that is running, as `Pace` heard of it."""

    cell: Cell
    started: float
    steps: int = 0
    settled: float = math.inf
    trained: float = math.inf
    marks: deque[tuple[float, int]] = field(default_factory=deque)

    def hear(self, steps: int, now: float) -> None:
        """It has done so many steps."""
        if steps > self.steps:
            self.settled = min(self.settled, now + SETTLING)
            if now < self.settled:
                self.marks.clear()
            self.marks.append((now, steps))
            while len(self.marks) > 2 and self.marks[1][0] <= now - WINDOW:
                self.marks.popleft()
            self.steps = steps
        if steps >= self.cell.steps:
            self.trained = min(self.trained, now)

    def begun(self, now: float) -> Begun:
        """How far it is."""
        (begin, before), (end, after) = (self.marks[0], self.marks[-1]) if self.marks else ((0.0, 0), (0.0, 0))
        per_step = (end - begin) / (after - before) if end - begin >= SHORTEST else None
        return Begun(self.cell, min(self.steps, self.cell.steps), per_step, max(now - self.trained, 0.0))


class Pace:
    """Hears what the cells of a run do, and says how long the rest takes.

    Attributes:
        at_once: How many cells ran at a time, at most, so far.
    """

    def __init__(self, cells: Sequence[Cell], now: Callable[[], float] = time.monotonic) -> None:
        """Begin before any cell does.

        Args:
            cells: Those that will be run, in order.
            now: The time, [s].
        """
        self._waiting = {cell.id: cell for cell in cells}
        self.at_once, self._now = 1, now
        self._running: dict[str, _Running] = {}
        self._ended: list[Manifest] = []

    def start(self, cell: Cell) -> None:
        """A cell begins."""
        self._waiting.pop(cell.id, None)
        self._running[cell.id] = _Running(cell, self._now())
        self.at_once = max(self.at_once, len(self._running))

    def hear(self, cell: Cell, steps: int) -> None:
        """A running cell has done so many steps."""
        self._running[cell.id].hear(steps, self._now())

    def end(self, cell: Cell, *, failed: bool = False) -> None:
        """A running cell has ended; what one took that failed says nothing of the others."""
        one = self._running.pop(cell.id)
        if not failed:
            now = self._now()
            trained = min(one.trained, now)
            self._ended.append(took(one.cell, trained - one.started, now - trained))

    @property
    def left(self) -> float | None:
        """Seconds until all cells have ended; None before that can be told."""
        now = self._now()
        begun = [one.begun(now) for one in self._running.values()]
        return time_left(self._ended, begun, [*self._waiting.values()], self.at_once)
