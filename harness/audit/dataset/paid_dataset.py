"""A data set paid by several rewards: what is kept of each step and of each episode. Observations are not."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.audit.dataset.payers import Payer
from harness.errors import HarnessError, SchemaError, one_line
from harness.record.dataset.dataset import Dataset, DatasetFacts, Nested, Piece, leaves
from harness.reward import LARGEST_PAID
from harness.score.places import ArmPlaces

MOST_STEPS = 20_000_000
"""The most steps of a data set: one number of each is kept, and one for each reward, 0.32 GB with one reward."""
LEARNT = 4_096
"""After so many steps it is known how much a number of an observation changes in a step."""
STILL = 0.05
"""A step that moves less than this part of the root mean square of all steps is one in which nothing happens."""
UNKNOWN, FAILURE, SUCCESS = -1, 0, 1


@dataclass(frozen=True, eq=False)
class PaidDataset:
    """What several rewards pay for a data set.

    Attributes:
        facts: Of the data set.
        paid: By reward, what it pays each step, (steps,), finite.
        failed: By reward that could not pay: why.
        moved: How far each step moved, (steps,), relative to the others.
        begins: Number of the first step of each episode, and behind the last the number of all steps, (episodes + 1,).
        numbers: Of the episodes in the data set, (episodes,).
        told: `SUCCESS`, `FAILURE` or `UNKNOWN`, (episodes,).
        operators: Who made each episode; empty texts if nothing says it.
        files: Where each lies.
    """

    facts: DatasetFacts
    paid: Mapping[str, Float]
    failed: Mapping[str, str]
    moved: Float
    begins: NDArray[np.int64]
    numbers: NDArray[np.int64]
    told: NDArray[np.int8]
    operators: tuple[str, ...]
    files: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.numbers)

    @property
    def steps(self) -> int:
        """How many steps there are."""
        return int(self.begins[-1])

    @cached_property
    def returns(self) -> Mapping[str, Float]:
        """By reward, the sum over each episode, (episodes,)."""
        return {name: self.summed(values) for name, values in self.paid.items()}

    @cached_property
    def still(self) -> Mask:
        """In which steps nothing happens, (steps,)."""
        root = float(np.sqrt(np.mean(np.square(self.moved))))
        still: Mask = self.moved <= STILL * root
        return still

    def summed(self, values: Float) -> Float:
        """The sum over each episode, (episodes,), of a number of each step, (steps,)."""
        sums: Float = np.add.reduceat(values, self.begins[:-1])
        return sums

    def episode_steps(self, place: int) -> slice:
        """The steps of the episode in this place."""
        return slice(int(self.begins[place]), int(self.begins[place + 1]))


def pay_dataset(dataset: Dataset, payers: Mapping[str, Payer], places: ArmPlaces | None = None) -> PaidDataset:
    """Pay all steps of a data set, reading a piece at a time.

    A reward that fails is left out, and the reason is told; the others go on.

    Args:
        dataset: It.
        payers: By name.
        places: Where the end effector stands, by which a step is told from standing still; None to take all numbers of
            an observation.

    Raises:
        SchemaError: The data set is damaged, or has more than 20 million steps.
        UsageError: The places are none of this data set.
    """
    kept = _Kept(payers)
    movement = _Movement(places)
    for piece in dataset.pieces():
        kept.take(piece)
        movement.take(piece)
        if kept.steps > MOST_STEPS:
            raise SchemaError(f"{dataset.facts.path} has more than {MOST_STEPS:,} steps, which is not allowed")
    if not kept.episodes:
        raise SchemaError(f"{dataset.facts.path} has no episode with a step that can be paid")
    numbers, told, operators, files, begins = zip(*kept.episodes, strict=True)
    return PaidDataset(
        dataset.facts,
        {name: np.concatenate(parts) for name, parts in kept.paid.items() if name not in kept.failed},
        kept.failed,
        movement.end(),
        np.array([*begins, kept.steps], np.int64),
        np.array(numbers, np.int64),
        np.array(told, np.int8),
        operators,
        files,
    )


class _Kept:
    """What is kept of the pieces. An episode without a step that can be paid is left out."""

    def __init__(self, payers: Mapping[str, Payer]) -> None:
        self._payers = payers
        self.paid: dict[str, list[Float]] = {name: [] for name in payers}
        self.failed: dict[str, str] = {}
        self.episodes: list[tuple[int, int, str, str, int]] = []
        self.steps = 0

    def take(self, piece: Piece) -> None:
        if not len(piece):
            if piece.first and piece.success:
                self._mark(SUCCESS)
            return
        if piece.first == 0:
            begins = (piece.episode, UNKNOWN, piece.operator, piece.file, self.steps)
            self.episodes.append(begins)
        if piece.success is not None:
            self._mark(SUCCESS if piece.success else FAILURE)
        for name, payer in self._payers.items():
            if name not in self.failed:
                self._pay(name, payer, piece)
        self.steps += len(piece)

    def _mark(self, told: int) -> None:
        number, before, *others = self.episodes[-1]
        self.episodes[-1] = (number, max(told, before), *others)  # type: ignore[assignment] # of the same types

    def _pay(self, name: str, payer: Payer, piece: Piece) -> None:
        try:
            paid = payer.pay(piece)
            if not (np.abs(paid) <= LARGEST_PAID).all():
                raise ValueError(f"it pays a number that is not finite, or beyond {LARGEST_PAID:g}")
        except HarnessError:
            raise
        except (Exception, SystemExit) as error:  # a plugin may raise anything
            self.failed[name] = f"episode {piece.episode}: {one_line(error)}"
            self.paid[name] = []
        else:
            self.paid[name].append(np.asarray(paid, np.float64))


class _Movement:
    """How far each step moves: the mean over the numbers of an observation, each by how much it changes in a step."""

    def __init__(self, places: ArmPlaces | None) -> None:
        self._places = places
        self._waiting: list[Float] = []
        self._count = 0
        self._scale: Float | None = None
        self._moved: list[Float] = []

    def take(self, piece: Piece) -> None:
        if not len(piece):
            return
        place = piece.observations
        vectors = flat_rows(place) if self._places is None else self._places.end_effector(place)
        change = np.abs(np.diff(vectors, axis=0))
        if self._scale is not None:
            self._moved.append(self._far(change))
            return
        self._waiting.append(change)
        self._count += len(change)
        if self._count >= LEARNT:
            self._learn()

    def end(self) -> Float:
        if self._scale is None:
            self._learn()
        return np.concatenate(self._moved)

    def _learn(self) -> None:
        self._scale = np.sqrt(np.mean(np.square(np.concatenate(self._waiting)), axis=0))
        self._moved = [self._far(change) for change in self._waiting]
        self._waiting = []

    def _far(self, change: Float) -> Float:
        assert self._scale is not None
        moves = self._scale > 0.0
        if not moves.any():
            return np.zeros(len(change))
        far: Float = np.mean(change[:, moves] / self._scale[moves], axis=1)
        return far


def flat_rows(rows: Nested) -> Float:
    """All numbers of each row, (rows, numbers)."""
    parts: Iterable[NDArray[np.generic]] = leaves(rows)
    return np.concatenate([np.asarray(part, np.float64).reshape(len(part), -1) for part in parts], axis=1)
