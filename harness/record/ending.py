"""What the record of a folder says, whatever was done there: how it ended, when, and on what."""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, ClassVar, Literal, TypeAlias, TypeVar

from harness.errors import SchemaError
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
    """

    status: Status
    reason: str = ""
    started: str = ""
    seconds: float = 0.0
    environment: Mapping[str, Any] = field(default_factory=dict)

    FORMAT: ClassVar[int]

    def to_json(self) -> dict[str, Any]:
        """Plain data, the format left out."""
        return asdict(self)

    def write(self, folder: Path) -> None:
        """Write ``manifest.json`` into `folder`, which is not complete yet."""
        text = json.dumps({"format": self.FORMAT, **self.to_json()}, indent=1)
        (folder / MANIFEST).write_text(text + "\n", encoding="utf-8")


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


def now() -> str:
    """The time in UTC, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")
