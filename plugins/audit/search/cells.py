"""Where episodes of one start went: rare places are begun from again, so that a success that is told late is met."""

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float

from .moves import Rng
from .world import Actions, Whole

PLACES = 600
"""Observations are cut into about so many cells, if they are few numbers."""
COARSEST = 3
"""Each number into at least so many."""
MOST = 20_000
"""Cells that are kept; what is new after that is not."""


class Cells:
    """For each cell of observations the shortest known way there, and how many episodes went through it."""

    def __init__(self, observes: gymnasium.Space[Any]) -> None:
        self._low, self._width = _bounds(observes)
        self._place: dict[bytes, int] = {}
        self._ways: list[Actions] = []
        self._steps: list[int] = []
        self._visits: list[int] = []

    def __len__(self) -> int:
        return len(self._ways)

    def add(self, trail: Float, genes: Actions) -> None:
        """Note where an episode went.

        Args:
            trail: Its observations, (steps + 1, size).
            genes: Its actions, (horizon, ...).
        """
        if self._low is None or len(self._low) != trail.shape[1]:
            self._low, self._width = trail.min(axis=0), np.maximum(np.ptp(trail, axis=0), 1e-6) / _parts(trail.shape[1])
        keys = np.floor((trail - self._low) / self._width).clip(-1e6, 1e6).astype(np.int32)
        cells, first = np.unique(keys, axis=0, return_index=True)
        for cell, step in zip(cells, first.tolist(), strict=True):
            self._visit(cell.tobytes(), step, genes)

    def _visit(self, key: bytes, step: int, genes: Actions) -> None:
        place = self._place.get(key)
        if place is None:
            if len(self) >= MOST:
                return
            self._place[key] = len(self)
            self._ways.append(genes)
            self._steps.append(step)
            self._visits.append(1)
            return
        self._visits[place] += 1
        if step < self._steps[place]:
            self._ways[place], self._steps[place] = genes, step

    def draw(self, rng: Rng, count: int) -> tuple[list[Actions], Whole]:
        """Ways to cells, rare ones more often, and after how many steps each is there, (count,)."""
        weights = 1.0 / np.sqrt(np.asarray(self._visits, np.float64))
        places = rng.choice(len(self), count, p=weights / weights.sum())
        return [self._ways[it] for it in places], np.asarray(self._steps, np.int64)[places]


def _parts(size: int) -> int:
    """Into how many cells each of so many numbers is cut."""
    return max(COARSEST, round(float(PLACES ** (1.0 / max(size, 1)))))


def _bounds(observes: gymnasium.Space[Any]) -> tuple[NDArray[Any] | None, NDArray[Any]]:
    """The lower bounds of observations and the width of a cell; None where a bound is open: the first episode tells."""
    if not isinstance(observes, gymnasium.spaces.Box) or not np.isfinite([observes.low, observes.high]).all():
        return None, np.ones(1)
    low, high = observes.low.astype(np.float64).ravel(), observes.high.astype(np.float64).ravel()
    return low, np.maximum(high - low, 1e-9) / _parts(len(low))
