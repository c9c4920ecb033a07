"""What a `manifest.json` says: what was done in its folder, how it ended, on what machine, with which versions.

And whether the folder, of a cell or of an evaluation elsewhere, still is what was left there.
"""

from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path, PurePosixPath
from typing import Any, ClassVar, Self, TypeVar

from pydantic import with_config

from harness.errors import SchemaError
from harness.files.bounded import digest_of, files_in, is_partial, reading, write_whole
from harness.files.plain import SUMS, Plain, read_sealed, seal
from harness.record.cell import Cell
from harness.record.earlier import whole_manifest
from harness.record.file_forms import EXACT, Digests, Environment, Line, Moment, Seconds, Status, Whole, read_form
from harness.record.folder import EVALUATIONS, LOG, MANIFEST, POLICY, SCORES, TENSORBOARD, begun_by, digests_in

SEALED_SINCE = 2
"""The first format of manifests, those of added folders included, that names the digests of its folder's files."""
SHOWN_DIGITS = 8
"""The digits of a hash of sources, where people read it."""
OF_A_GOAL = ("error", "unit")
"""Left out of the file where the task has none: it is as it was before there were any."""
Record = TypeVar("Record", bound="Ending")
REMEDY = "run again to replace it"
NO_RECORDINGS = (".", EVALUATIONS, POLICY)
"""Folders of a cell, its own included, whose files are no recording."""
PAID_LATER = "scores"
"""What the names of files begin with that `harness score` adds to a cell."""
KERNEL = "kernel of OpenBLAS"
"""What people read for what `harness.experiment.provenance.blas_kernel` tells."""


@with_config(EXACT)
@dataclass(frozen=True, kw_only=True)
class Ending(Plain):
    """How the work for one folder ended.

    Attributes:
        status: ``done``, ``failed``, ``skipped``, ``pending``, ``damaged`` or, where the answer stands without it,
            ``not needed``; the last three are never written.
        reason: Why it is not done; empty if it is.
        started: UTC, ISO 8601.
        seconds: Wall time of all of it, [s].
        environment: Versions, machine, engine, commit, command, hashes of the sources; see
            `harness.experiment.provenance.describe_environment`.
        files: SHA-256 of every other file in the folder, by its path there.
    """

    status: Status
    reason: Line = ""
    started: Moment = ""
    seconds: Seconds = 0.0
    environment: Environment = field(default_factory=dict)
    files: Digests = field(default_factory=dict)

    FORMAT: ClassVar[int]

    def write(self, folder: Path) -> Self:
        """Write ``manifest.json`` into `folder`, which is not complete yet, with the digest of every file there.

        Returns:
            What was written: the record with those digests.
        """
        record = replace(self, files=digests_in(folder))
        write_whole(folder / MANIFEST, seal({"format": self.FORMAT, **record.to_json()}))
        return record


@with_config(EXACT)
@dataclass(frozen=True)
class Manifest(Ending):
    """The record of one cell.

    Attributes:
        cell: What was run.
        training_seconds: Of the training alone, up to the checkpoint it was resumed from included, [s].
        resumed_from: Environment steps that an earlier process, which was killed, left in a checkpoint; 0 if none did.
        note: What there is to know of it: where the training went on after such a process, or why it started over. In
            an environment also that no episode ended, how many episodes of the evaluation were cut, and which rewards
            and measures failed while they looked on.
        peak_memory: The most that the cell's process had in memory at once, in bytes; 0 if it is not known.
        error: What the task calls the distance that it measures, as ``pose error``; empty if that is the distance from
            end effector to target, in metres.
        unit: Of the error.
    """

    cell: Cell
    training_seconds: Seconds = 0.0
    resumed_from: Whole = 0
    note: Line = ""
    peak_memory: Whole = 0
    error: Line = ""
    unit: Line = ""

    FORMAT: ClassVar[int] = 2

    def to_json(self) -> dict[str, Any]:
        """Plain data; the cell's id stands beside it, for who looks for it."""
        told = {"id": self.cell.id, **super().to_json()}
        return told if self.error else {name: value for name, value in told.items() if name not in OF_A_GOAL}


def read_manifest(folder: Path) -> Manifest:
    """The manifest in a cell's folder.

    Raises:
        SchemaError: It is damaged or written by a newer version.
    """
    return read_record(folder, Manifest, "manifest")


def read_record(folder: Path, kind: type[Record], noun: str) -> Record:
    """What the ``manifest.json`` in `folder` tells.

    Args:
        folder: Of a cell, or one that a command added.
        kind: Of the record. The annotations of its fields say what may stand in the file.
        noun: What the file should be, for the message if it is not.

    Raises:
        SchemaError: The file is damaged, or written by a newer version.
    """
    path = folder / MANIFEST
    data = read_sealed(path, noun, kind.FORMAT, SEALED_SINCE)
    with reading(path, noun):
        if "files" not in data and data.get("format", 1) < SEALED_SINCE:
            data = whole_manifest(data, folder)
        if not {"format", "files"} <= data.keys():
            raise ValueError("it tells no format, or no digests of files")
        told = {name: it for name, it in data.items() if name not in ("format", "id")}
        return read_form(kind, told)


def now() -> str:
    """The time in UTC, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def write_log(path: Path, text: str) -> None:
    """Append a line with the time, UTC."""
    with path.open("a", encoding="utf-8") as log:
        log.write(f"{now()} harness: {text}\n")


def whole_cell(folder: Path) -> Manifest:
    """The manifest of the cell whose folder this is, by its name, if every file is what the cell left.

    Raises:
        SchemaError: It is not.
        NewerFormat: A newer version made the cell.
    """
    try:
        if folder.is_symlink() or not folder.is_dir():
            raise SchemaError(f"{folder} is no folder")
        manifest = read_manifest(folder)
        if manifest.cell.id != folder.name:
            raise SchemaError(f"{folder} holds another cell, {manifest.cell.id}")
        require_files(folder, manifest)
        # A reader takes all that lies in the folder of a recording, and all parts of a trace.
        recordings = {PurePosixPath(name).parent for name in manifest.files} - {*map(PurePosixPath, NO_RECORDINGS)}
        for name in added_files(folder, manifest):
            if PurePosixPath(name).parent in recordings or begun_by(name) in manifest.files:
                raise SchemaError(f"{folder / name} was added to what was recorded")
    except OSError as error:
        raise SchemaError(f"{folder} cannot be read: {error.strerror}") from error
    return manifest


def require_files(folder: Path, record: Ending) -> None:
    """See whether the files in `folder` are those that its record names.

    Raises:
        SchemaError: One is not what was written, or is missing and no report can do without it; the message names it.
    """
    for name, digest in record.files.items():
        path = folder / name
        if path.is_symlink():
            raise SchemaError(f"{path} is a link")
        if not path.is_file():
            if is_needed(name):
                raise SchemaError(f"{path} is missing")
            continue
        try:
            found = digest_of(path)
        except OSError as error:
            raise SchemaError(f"{path} cannot be read: {error.strerror}") from error
        if found != digest:
            raise SchemaError(f"{path} is not what was written: its SHA-256 differs")


def is_named(record: Ending, name: str) -> bool:
    """Whether a record names a file, or files of a folder."""
    return name in record.files or any(known.startswith(f"{name}/") for known in record.files)


def added_files(folder: Path, record: Ending) -> list[str]:
    """Files in `folder` that its record does not name, nor a command of the harness adds. No report reads them."""
    there = [path for path in files_in(folder) if path.name not in (MANIFEST, SUMS) and not is_partial(path)]
    names = [path.relative_to(folder).as_posix() for path in there if not path.name.startswith(PAID_LATER)]
    return [name for name in names if name not in record.files]


def is_needed(name: str) -> bool:
    """Whether reports read this file of a cell; others may be taken away, to make a folder smaller."""
    return PurePosixPath(name).parts[0] not in (POLICY, TENSORBOARD, LOG, SCORES)
