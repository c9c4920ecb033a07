"""Whether the folder of a cell, or of an evaluation elsewhere, still is what was left there."""

from pathlib import Path, PurePosixPath

from harness.errors import NewerFormat, SchemaError
from harness.files.bounded import digest_of
from harness.record.cell import Cell
from harness.record.folder import EVALUATION, LOG, POLICY, RANDOM, SCORES, TENSORBOARD, TRACE
from harness.record.manifest import Ending, Manifest, read_manifest
from harness.record.trace import read_trace

REMEDY = "run again to replace it"


def examine(folder: Path, cell: Cell) -> Manifest:
    """What there is to say of a cell: its manifest, if every file is what the cell left; else damaged, or pending.

    Raises:
        NewerFormat: A newer version made the cell.
    """
    if not folder.is_symlink() and not folder.exists():
        return Manifest(cell, status="pending", reason="not run yet")
    try:
        manifest = _own_manifest(folder, cell)
        require_files(folder, manifest)
        if not manifest.files and manifest.status == "done":
            _require_readable(folder)
    except NewerFormat:
        raise
    except SchemaError as error:
        return Manifest(cell, status="damaged", reason=f"{error}; {REMEDY}")
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


def is_needed(name: str) -> bool:
    """Whether reports read this file of a cell; others may be taken away, to make a folder smaller."""
    return PurePosixPath(name).parts[0] not in (POLICY, TENSORBOARD, LOG, SCORES)


def _own_manifest(folder: Path, cell: Cell) -> Manifest:
    if folder.is_symlink() or not folder.is_dir():
        raise SchemaError(f"{folder} is no folder")
    manifest = read_manifest(folder)
    if manifest.cell.id != cell.id:
        raise SchemaError(f"{folder} holds another cell, {manifest.cell.id}")
    return manifest


def _require_readable(folder: Path) -> None:
    """The least that can be asked of a done cell of version 0.1, which names no digests."""
    for name in (TRACE, EVALUATION, RANDOM):
        read_trace(folder / name, ["reward"])
