"""How far each step of a data set moves."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.record.dataset.dataset import Nested, Piece, leaves
from harness.score.places import ArmPlaces

LEARNT = 4_096
"""After so many steps it is known how much a number of an observation changes in a step."""


class Movement:
    """How far each step moves: the mean over the numbers of an observation, each by how much it changes in a step.

    Observations of another size, in the env of another task, have a scale of their own.
    """

    def __init__(self, places: ArmPlaces | None) -> None:
        self._places = places
        self._waiting: dict[int, list[tuple[int, Float]]] = {}
        self._count: dict[int, int] = {}
        self._scale: dict[int, Float] = {}
        self._moved: list[Float] = []

    def take(self, piece: Piece) -> None:
        """The next piece."""
        moved = np.full(len(piece), np.nan)
        self._moved.append(moved)
        if piece.flaw or not piece.seen:
            return
        place = piece.observations
        vectors = flat_rows(place) if self._places is None else self._places.end_effector(place)
        change = np.abs(np.diff(vectors, axis=0))
        width = change.shape[1]
        if not width:
            moved[: len(change)] = np.inf
            return
        if width in self._scale:
            moved[: len(change)] = self._far(change)
            return
        self._waiting.setdefault(width, []).append((len(self._moved) - 1, change))
        self._count[width] = self._count.get(width, 0) + len(change)
        if self._count[width] >= LEARNT:
            self._learn(width)

    def end(self) -> Float:
        """How far each step moved, (steps,); see `PaidDataset.moved`."""
        for width in tuple(self._waiting):
            self._learn(width)
        return np.concatenate(self._moved)

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


def flat_rows(rows: Nested) -> Float:
    """All numbers of each row, (rows, numbers)."""
    parts: Iterable[NDArray[np.generic]] = leaves(rows)
    return np.concatenate([np.asarray(part, np.float64).reshape(len(part), -1) for part in parts], axis=1)
