"""How far each step of a data set moves."""

from typing import TYPE_CHECKING

import numpy as np

from harness.arrays import Float
from harness.log import Rows
from harness.log.log import BEFORE, OBSERVATION
from harness.payoff.dataset.steps import flat_rows, vectors_of

if TYPE_CHECKING:
    from harness.score.places import ArmPlaces

LEARNT = 4_096
"""After so many steps it is known how much a number of an observation changes in a step."""


class Movement:
    """How far each step moves: the mean over the numbers of an observation, each by how much it changes in a step.

    Observations of another size, in the env of another task, have a scale of their own.
    """

    def __init__(self, places: "ArmPlaces | None") -> None:
        self._places = places
        self._waiting: dict[int, list[tuple[int, Float]]] = {}
        self._count: dict[int, int] = {}
        self._scale: dict[int, Float] = {}
        self._moved: list[Float] = []

    def take(self, rows: Rows, seen: int) -> None:
        """The next steps of one episode, of which it is known what was seen after the first `seen`."""
        moved = np.full(len(rows), np.nan)
        self._moved.append(moved)
        if not seen:
            return
        before, after = (self._positions(rows, name) for name in (f"{BEFORE}{OBSERVATION}", OBSERVATION))
        change = np.abs(after[:seen] - before[:seen])
        width = change.shape[1]
        if not width:
            moved[:seen] = np.inf
        elif width in self._scale:
            moved[:seen] = self._far(change)
        else:
            self._waiting.setdefault(width, []).append((len(self._moved) - 1, change))
            self._count[width] = self._count.get(width, 0) + seen
            if self._count[width] >= LEARNT:
                self._learn(width)

    def end(self) -> Float:
        """How far each step moved, (steps,); see `PaidDataset.moved`."""
        for width in tuple(self._waiting):
            self._learn(width)
        return np.concatenate(self._moved)

    def _positions(self, rows: Rows, name: str) -> Float:
        if self._places is None:
            return flat_rows(rows, name)
        return self._places.end_effector(vectors_of(rows.columns, name))

    def _learn(self, width: int) -> None:
        waiting = self._waiting.pop(width)
        self._scale[width] = np.sqrt(np.mean(np.square(np.concatenate([change for _, change in waiting])), axis=0))
        for place, change in waiting:
            self._moved[place][: len(change)] = self._far(change)

    def _far(self, change: Float) -> Float:
        scale = self._scale[change.shape[1]]
        moves = scale > 0.0
        if not moves.any():
            return np.zeros(len(change))
        far: Float = np.mean(change[:, moves] / scale[moves], axis=1)
        return far
