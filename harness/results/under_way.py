"""What trainings that go on, or that were killed, have recorded so far, and what that hints at."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import ceil, inf, log, log2, sqrt
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtr

from harness.arrays import Float
from harness.errors import SchemaError, one_line
from harness.eta.laws import Better, direction_of
from harness.log.log import SUCCESS, are_flags
from harness.record.cell import Cell
from harness.record.folder import TRACE, TRAINING_RECORDING, partial_folder
from harness.record.progress import LAST_EPISODES
from harness.record.recording.facts import facts_of
from harness.record.recording.recorded_training import is_recording, read_recording
from harness.record.store import Store
from harness.record.trace import PAID, read_trace
from harness.results.cell_results import learned
from harness.results.recordings.episodes import episodes_of

ERROR = 0.05
"""Whoever bets on neighbours, or on low success, wins as much as is asked for in at most this share of trainings.

That holds where chance hits each episode anew. Luck that lasts is a fall, or low success, while it lasts:
`tests.plugins.watch.cases.nulls` counts how often.
"""
BETS = np.array([0.2, 0.5, 0.8])
"""Shares of their money that three players bet on each pair of neighbours."""
RARE = np.array([0.02, 0.1])
"""Chances of success of two players who bet that it is below `LOW`."""
MOST, LEAST = 64, 5
"""The most blocks of a training, and the least of each half."""
LEAST_SHARE, LEAST_OF_RANGE = 0.1, 0.2
"""A smaller change of success does not matter; of another measure one by less of the range of all blocks."""
LOW, FIRST = 0.25, 1.0 / 3.0
"""Success that stays is hinted at below the first, and after the second as a share of the training's steps."""
ROSE, FELL = -log(0.005), -log(0.0001)
"""What pay that rose, and behaviour that fell, has to reach as a surprise, in nats."""


class SoFar(NamedTuple):
    """How far the rows of a training go, and what its last episodes came to."""

    recorded: int | None
    """Steps; None of damaged rows."""
    mean_return: float | None
    """What an episode was paid; None before one has ended."""
    success: float | None
    """The share of those that succeeded; None likewise, or where nothing measures it."""
    hint: str
    """What it hints at; see `hint_of`."""
    text: str
    """All of it, for people."""


def so_far(cell: Cell, store: Store) -> SoFar | None:
    """What is there of a training that has not ended; None before its first row."""
    try:
        found = _recorded(partial_folder(store.cell_folder(cell)))
    except SchemaError as error:
        return SoFar(None, None, None, "", one_line(error))
    if found is None:
        return None
    told, last = f"{found.steps:,} of {cell.steps:,} steps recorded", found.pay[-LAST_EPISODES:]
    if not len(last):
        return SoFar(found.steps, None, None, "", f"{told}, and no episode has ended")
    pay, did = float(last.mean()), float(found.behaviour[-LAST_EPISODES:].mean())
    told += f"; its last {len(last)} episodes were paid {pay:.4g} on average"
    success = did if found.measure == SUCCESS else None
    told += "" if success is None else f", and {success:.0%} succeeded"
    hint = found.hint(cell.steps)
    return SoFar(found.steps, pay, success, hint, ". ".join(filter(None, (told, hint.rstrip(".")))))


class Recorded(NamedTuple):
    """The episodes of a training that have ended, (episodes,) each; see `hint_of`."""

    steps: int
    ended: NDArray[np.int64]
    pay: Float
    behaviour: Float
    measure: str
    better: Better

    def hint(self, asked: int) -> str:
        """What they hint at in a training of so many steps; of 0, if nobody said how many."""
        return hint_of(*self[1:], asked)


def of_recording(folder: Path) -> Recorded:
    """What a recorded training has, one that goes on too.

    Raises:
        SchemaError: It is damaged.
    """
    log = read_recording(folder)
    facts, episodes = facts_of(log), episodes_of(log)
    measure = measure_of(facts.behaviour)
    behaviour = episodes.behaviour.get(measure, np.full(len(episodes.last), np.nan))
    better = direction_of(measure, facts.lower_is_better, facts.higher_is_better, is_flag=are_flags(behaviour))
    return Recorded(len(log), episodes.last + 1, episodes.returns[facts.trained_with], behaviour, measure, better)


def _recorded(folder: Path) -> Recorded | None:
    """What a folder has of a cell's training; None before the first row.

    Raises:
        SchemaError: It is damaged.
    """
    if is_recording(folder / TRAINING_RECORDING):
        return of_recording(folder / TRAINING_RECORDING)
    if (folder / TRACE).exists():
        trace = read_trace(folder / TRACE)
        steps, (last, reached, pay) = np.cumsum(trace["step"] > 0), learned(trace, PAID).reshape(3, -1)
        return Recorded(int(steps.max(initial=0)), steps[last.astype(int)], pay, reached, SUCCESS, "higher")
    return None


def measure_of(measures: Sequence[str]) -> str:
    """The measure that is shown: success, or the first one; empty without one."""
    return SUCCESS if SUCCESS in measures else next(iter(measures), "")


def hint_of(
    steps: NDArray[np.int64], pay: Float, behaviour: Float, measure: str, better: Better, asked: int = 0
) -> str:
    """What a training's episodes hint at so far, in one line; empty if nothing, or if the behaviour has improved.

    Neighbours: of two episodes beside one another the worse one is mostly paid more. Halves: pay rose while the
    behaviour fell, or while success stayed low.

    Args:
        steps: Environment steps of the training when each episode had ended, (episodes,), which grow.
        pay: Of each.
        behaviour: Of each; NaN where nobody measured it.
        measure: Its name.
        better: Which values are better; where nobody says it, nothing is hinted at.
        asked: How many steps there will be. Where nobody said it, 0, success that stays is not hinted at.
    """
    if not better or len(pay) < 2 * LEAST or np.isnan(behaviour).any():
        return ""
    is_flag = are_flags(behaviour)
    good, size = -behaviour if better == "lower" else behaviour, 2 ** max(0, ceil(log2(len(pay) / MOST)))
    paid, did = _Series.of(pay, size), _Series.of(good, size)
    least, quarter = LEAST_SHARE if is_flag else LEAST_OF_RANGE * float(np.ptp(did.means)), len(good) // 4
    surely = 2.0 * float(np.std(good)) * sqrt(2.0 / quarter)
    if np.mean(good[-quarter:]) - np.mean(good[:quarter]) >= max(least, surely) > 0.0:
        return ""
    told, name = "", measure.replace("_", " ")
    wins = np.fromiter(_won_by_flags(pay, good) if is_flag else _won(pay, good), float)
    money = np.logaddexp.reduce(np.log1p(np.outer(BETS, 2.0 * wins - 1.0)).sum(axis=1)) - log(len(BETS))
    if money >= -log(ERROR):
        worse = "failed" if is_flag else f"had the worse {name}"
        won = f"{np.count_nonzero(wins == 1.0):,} of {len(wins):,}"
        told = f"In {won} pairs of neighbouring episodes the one that {worse} was paid more"
    elif paid.half >= LEAST and paid.surprise() >= ROSE:
        before, now = did.halves
        fell = before - now >= least and did.surprise(-1.0) >= FELL
        is_late = 0 < FIRST * asked <= steps[-1]
        if fell or (now - before < least and is_flag and is_late and _stays_low(good, steps, asked)):
            earned, earns = (f"{it:.3g}" for it in paid.halves)
            first, last = (f"{100 * it:.0f} %" if is_flag else f"{abs(it):.3g}" for it in (before, now))
            moved = "stayed low: from" if not fell else "rose from" if better == "lower" else "fell from"
            since = f"since step {steps[(len(paid.means) - paid.half) * size - 1]:,}"
            told = f"Pay rose from {earned} to {earns} {since} while {name} {moved} {first} to {last}"
    return told and f"{told}. It is a hint, not a verdict."


def _won_by_flags(pay: Float, good: Float) -> Iterator[float]:
    """Whether the failing side of each pair was paid more; 1/2 where both were paid alike.

    A pair is a run of equal outcomes, by the episode in its middle, and the two episodes around it: so luck that lasts
    makes fewer pairs, and pay that drifts no winner.
    """
    used = 0
    for begin, end in pairwise((np.flatnonzero(np.diff(good)) + 1).tolist()):
        if begin <= used:  # the episode before it is in the last pair
            continue
        inside, around = pay[(begin + end - 1) // 2], (pay[begin - 1] + pay[end]) / 2.0
        yield 0.5 if inside == around else float((inside > around) == (good[begin] < good[end]))
        used = end + 1


def _won(pay: Float, good: Float) -> Iterator[float]:
    """Whether the worse one of each two episodes that differ in both was paid more."""
    rows = slice(len(pay) // 2 * 2)
    signs = np.diff(pay[rows].reshape(-1, 2)) * np.diff(good[rows].reshape(-1, 2))
    yield from (signs[signs != 0.0] < 0.0).tolist()


def _stays_low(good: Float, steps: NDArray[np.int64], asked: int) -> bool:
    """Whether the chance of success is surely below `LOW`.

    Players bet on that, half of their money from the first episode on, and half of it after `FIRST` of the steps.
    """
    odds = np.log(np.array([(1.0 - RARE) / (1.0 - LOW), RARE / LOW]))
    money = [np.logaddexp.reduce(odds[it.astype(int)].sum(axis=0)) for it in (good, good[steps >= FIRST * asked])]
    return bool(np.logaddexp.reduce(money) >= log(2 * len(RARE) / ERROR))


@dataclass(frozen=True, eq=False)
class _Series:
    """A number of a training's episodes, by block.

    Attributes:
        means: (blocks,).
        variances: Of the mean of a block, from what its episodes differ by, (blocks,); 0 of one episode.
    """

    means: Float
    variances: Float

    @classmethod
    def of(cls, numbers: Float, size: int) -> Self:
        """The series of all blocks of so many episodes; those behind them are left out."""
        blocks = numbers[: len(numbers) // size * size].reshape(-1, size)
        return cls(blocks.mean(axis=1), blocks.var(axis=1, ddof=1) / size if size > 1 else np.zeros(len(blocks)))

    @property
    def half(self) -> int:
        """Blocks of each half."""
        return len(self.means) // 2

    @property
    def halves(self) -> tuple[float, float]:
        """The mean of the earlier half and of the later one."""
        return float(self.means[: self.half].mean()), float(self.means[-self.half :].mean())

    def surprise(self, sign: float = 1.0) -> float:
        """The surprise that the mean rose, or with -1 fell, as it did, in nats: -log p of a t test."""
        before, now = self.halves
        moved, error = sign * (now - before), self._error
        if error == 0.0 or moved <= 0.0:
            return inf if moved > 0.0 else 0.0
        chance = float(stdtr(2 * self.half - 2, -moved / sqrt(error)))
        return -log(chance) if chance > 0.0 else inf

    @property
    def _error(self) -> float:
        """The larger of two errors of the difference of the halves: from block to block, and within blocks.

        What neighbours differ by is taken, so that a drift is no error; how alike they are makes it larger.
        """
        within = 2.0 * float(np.mean(self.variances))
        alone = (1.0 - self.alike) / (1.0 + self.alike)  # so much of a block says something new
        return max(float(np.mean(np.diff(self.means) ** 2)), within) / alone / self.half

    @cached_property
    def alike(self) -> float:
        """How much of a deviation stays to the next block, 0 to 0.9: blocks two apart differ by more than neighbours.

        A deviation is one from the straight line of its half, so that what is learnt is none; where success is rare the
        line says little, and most stays. Of medians, so that a jump does not count.
        """
        halves, clock = np.array([self.means[: self.half], self.means[-self.half :]]), np.arange(self.half)
        slope, height = np.polyfit(clock, halves.T, 1)
        apart = halves - height[:, np.newaxis] - np.outer(slope, clock)
        near, far = (float(np.median((apart[:, gap:] - apart[:, :-gap]) ** 2)) for gap in (1, 2))
        return min(max(far / near - 1.0, 0.0), 0.9) if near > 0.0 else 0.0
