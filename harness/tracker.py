"""The interface that a tracker fills: it shows trainings elsewhere, as TensorBoard, Weights & Biases and MLflow do."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Protocol, TypeAlias

Outcome: TypeAlias = Literal["done", "failed", "interrupted"]


@dataclass(frozen=True)
class TrackedCell:
    """A cell as trackers are told of it.

    Attributes:
        id: No other cell has it, nor the same cell when it is done again: digits, letters and ``-``, 28 at most. A cell
            that goes on from a checkpoint after its run was killed has the one that it had before.
        title: For people: the combination and the seed.
        group: For people: the combination. The seeds of a combination have the same.
        config: Every parameter of the cell by name, such as ``reward.k1``; text, numbers, bool, None and lists of them.
        folder: Of the experiment. A tracker may have a folder of its own name in it.
    """

    id: str
    title: str
    group: str
    config: Mapping[str, Any]
    folder: Path


class Track(Protocol):
    """What a tracker keeps of one cell."""

    def log(self, steps: int, scalars: Mapping[str, float]) -> None:
        """Numbers by name, such as ``Training/Success Rate``, as they are after `steps` environment steps.

        `steps` never falls below what it was, except within the last words of an evaluation; the same steps may come
        several times, with other names. Numbers may be NaN or infinite.
        """

    def end(self, outcome: Outcome, reason: str) -> None:
        """The cell has ended, `reason` says why it failed. Nothing is logged afterwards."""


class Tracker(Protocol):
    """A frozen dataclass whose fields are its settings: ``--tracker wandb:project=arms,mode=offline``.

    All calls but `why_not` come from one thread, which is not the one that runs the experiment: a tracker may wait for
    a server. One that raises is not called again, and the cells go on.
    """

    def why_not(self) -> str:
        """Why it cannot be used here and now, with the remedy; empty if it can. Writes nothing and asks nobody."""

    def begin(self, cell: TrackedCell) -> Track:
        """A cell begins, or goes on: then `cell.id` is one that was begun before, by another process.

        Several cells are tracked at once. What was logged of a cell that goes on is not logged again.
        """
