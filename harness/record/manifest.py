"""What a cell says of itself: what it was, how it ended, on what machine and with which versions it ran."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from harness.record.cell import Cell
from harness.record.ending import Ending, read_record


@dataclass(frozen=True)
class Manifest(Ending):
    """The record of one cell.

    Attributes:
        cell: What was run.
        training_seconds: Of the training alone, up to the checkpoint it was resumed from included, [s].
        resumed_from: Environment steps that an earlier process, which was killed, left in a checkpoint; 0 if none did.
        note: After such a process: where the training went on, or why it started over.
    """

    cell: Cell
    training_seconds: float = 0.0
    resumed_from: int = 0
    note: str = ""

    FORMAT: ClassVar[int] = 1

    def to_json(self) -> dict[str, Any]:
        """Plain data; the cell's id stands beside it, for who looks for it."""
        return {"id": self.cell.id, **super().to_json(), "cell": self.cell.to_json()}


def read_manifest(folder: Path) -> Manifest:
    """The manifest in a cell's folder.

    Raises:
        SchemaError: It is damaged or written by a newer version.
    """
    return read_record(folder, Manifest.FORMAT, "manifest", _from_json)


def _from_json(data: dict[str, Any]) -> Manifest:
    del data["id"]  # of the cell, which is there whole
    return Manifest(**{**data, "cell": Cell.from_json(data["cell"])})
