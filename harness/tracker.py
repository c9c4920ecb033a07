"""The interface that a tracker fills: it shows trainings elsewhere, as TensorBoard, Weights & Biases and MLflow do."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Protocol, TypeAlias

__all__ = ["Outcome", "Track", "TrackedCell", "Tracker"]

Outcome: TypeAlias = Literal["done", "failed", "interrupted"]


@dataclass(frozen=True)
class TrackedCell:
    """What a tracker gets to know about a cell.

    Attributes:
        id: At most 28 digits, letters and ``-``. No other cell has this id. A cell that is done again from the start
            gets a new id. A cell that goes on from a checkpoint after its run was killed keeps its id.
        title: A name for people: the combination and the seed.
        group: A name for people: the combination. All seeds of a combination share it.
        config: Every parameter of the cell by name, such as ``reward.k1``; text, numbers, bool, None and lists of them.
        folder: The experiment's folder. A tracker may make a folder of its own name in it.
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

        `steps` never becomes smaller, except in the last calls of an evaluation. Several calls may have the same
        `steps`, with other names. Numbers may be NaN or infinite.
        """

    def end(self, outcome: Outcome, reason: str) -> None:
        """The cell has ended. If it failed, `reason` says why. `log` is not called afterwards."""


class Tracker(Protocol):
    """A frozen dataclass whose fields are its settings: ``--tracker wandb:project=arms,mode=offline``.

    All calls except `why_not` come from one thread. It is not the thread that runs the experiment, so a tracker may
    wait for a server. A tracker that raises an exception is not called again, and the cells go on.
    """

    def why_not(self) -> str:
        """Why it cannot be used now, and what to do about it; empty if it can. Writes nothing, calls no server."""

    def begin(self, cell: TrackedCell) -> Track:
        """A cell begins, or it goes on. If it goes on, another process has called `begin` with the same `cell.id`.

        Several cells are tracked at once. If a cell goes on, what was logged before is not logged again.
        """
