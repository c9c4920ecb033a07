"""What a `manifest.json` says: what was done in its folder, how it ended, on what machine, with which versions."""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, ClassVar, Literal, TypeAlias, TypeVar

from harness.errors import SchemaError
from harness.files.bounded import digest_of
from harness.files.whole_file import write_whole
from harness.record.cell import Cell
from harness.record.folder import MANIFEST

Status: TypeAlias = Literal["done", "failed", "skipped", "pending"]
Told = TypeVar("Told")


@dataclass(frozen=True, kw_only=True)
class Ending:
    """How the work for one folder ended.

    Attributes:
        status: ``done``, ``failed``, ``skipped`` or ``pending``.
        reason: Why it is not done; empty if it is.
        started: UTC, ISO 8601.
        seconds: Wall time of all of it, [s].
        environment: Versions, machine, commit, command, hashes of the sources; see
            `harness.experiment.provenance.describe_environment`.
        files: SHA-256 of every other file in the folder, by its path there; cells of version 0.1 have none.
    """

    status: Status
    reason: str = ""
    started: str = ""
    seconds: float = 0.0
    environment: Mapping[str, Any] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)

    FORMAT: ClassVar[int]

    def to_json(self) -> dict[str, Any]:
        """Plain data, the format left out."""
        return asdict(self)

    def write(self, folder: Path) -> None:
        """Write ``manifest.json`` into `folder`, which is not complete yet, with the digest of every file there."""
        record = replace(self, files=digests_in(folder))
        text = json.dumps({"format": self.FORMAT, **record.to_json()}, indent=1)
        write_whole(folder / MANIFEST, text + "\n")


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


def read_record(folder: Path, version: int, noun: str, read: Callable[[dict[str, Any]], Told]) -> Told:
    """What `read` makes of the ``manifest.json`` in `folder`.

    Args:
        folder: Of a cell, or of an evaluation in another simulator.
        version: The newest format that can be read.
        noun: What the file should be, for the message if it is not.
        read: Gets the file's keys, the format left out.

    Raises:
        SchemaError: The file is damaged, or written by a newer version.
    """
    path = folder / MANIFEST
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        found = data.pop("format")
        if found > version:
            raise SchemaError(f"{path} has format {found}, this version reads up to {version}")
        return read(data)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise SchemaError(f"{path} is no readable {noun}: {error!r}") from error


def digests_in(folder: Path) -> dict[str, str]:
    """SHA-256 of every file in a folder but its manifest, by its path there; links are left out."""
    paths = [path for path in sorted(folder.rglob("*")) if path.is_file() and not path.is_symlink()]
    return {str(path.relative_to(folder).as_posix()): digest_of(path) for path in paths if path != folder / MANIFEST}


def now() -> str:
    """The time in UTC, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")
