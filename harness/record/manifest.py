"""What a cell says of itself: what it was, how it ended, on what machine and with which versions it ran."""

import json
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal, TypeAlias

from harness.errors import SchemaError
from harness.record.cell import Cell
from harness.record.folder import MANIFEST

FORMAT = 1
Status: TypeAlias = Literal["done", "failed", "skipped", "pending"]


@dataclass(frozen=True)
class Manifest:
    """The record of one cell.

    Attributes:
        cell: What was run.
        status: ``done``, ``failed``, ``skipped`` or ``pending``.
        reason: Why it is not done; empty if it is.
        started: UTC, ISO 8601.
        seconds: Wall time of the whole cell.
        training_seconds: Of the training alone, up to the checkpoint it was resumed from included.
        environment: Versions, machine, commit, command, hashes of the sources; see `describe_environment`.
        resumed_from: Environment steps that an earlier process, which was killed, left in a checkpoint; 0 if none did.
        note: After such a process: where the training went on, or why it started over.
    """

    cell: Cell
    status: Status
    reason: str = ""
    started: str = ""
    seconds: float = 0.0
    training_seconds: float = 0.0
    environment: dict[str, Any] = field(default_factory=dict)
    resumed_from: int = 0
    note: str = ""

    def write(self, folder: Path) -> None:
        """Write ``manifest.json`` into `folder`."""
        data = {"format": FORMAT, "id": self.cell.id, **asdict(self), "cell": self.cell.to_json()}
        (folder / MANIFEST).write_text(json.dumps(data, indent=1) + "\n")


def read_manifest(folder: Path) -> Manifest:
    """The manifest in a cell's folder.

    Raises:
        SchemaError: It is damaged or written by a newer version.
    """
    path = folder / MANIFEST
    try:
        data = json.loads(path.read_text())
        version = data.pop("format")
        if version > FORMAT:
            raise SchemaError(f"{path} has format {version}, this version reads up to {FORMAT}")
        del data["id"]
        return Manifest(**{**data, "cell": Cell.from_json(data["cell"])})
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise SchemaError(f"{path} is no readable manifest: {error!r}") from error


def now() -> str:
    """The time in UTC, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")
