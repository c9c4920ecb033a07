"""Whether the folder of a cell, or of an evaluation elsewhere, still is what was left there."""

from pathlib import Path, PurePosixPath

from harness.errors import NewerFormat, SchemaError
from harness.files.bounded import digest_of
from harness.files.sums import SUMS
from harness.files.whole_file import files_in, is_partial
from harness.record.cell import Cell
from harness.record.folder import EVALUATIONS, LOG, MANIFEST, POLICY, SCORES, TENSORBOARD
from harness.record.manifest import Ending, Manifest, read_manifest

REMEDY = "run again to replace it"
NO_RECORDINGS = (".", EVALUATIONS, POLICY)
"""Folders of a cell, its own included, whose files are no recording."""
PAID_LATER = "scores"
"""What the names of files begin with that `harness score` adds to a cell."""


def examine(folder: Path, cell: Cell) -> Manifest:
    """What there is to say of a cell: its manifest, if every file is what the cell left; else damaged, or pending.

    Raises:
        NewerFormat: A newer version made the cell.
    """
    if not folder.is_symlink() and not folder.exists():
        return Manifest(cell, status="pending", reason="not run yet")
    try:
        return whole_cell(folder)
    except NewerFormat:
        raise
    except SchemaError as error:
        return Manifest(cell, status="damaged", reason=f"{error}; {REMEDY}")


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
        # A reader takes all that lies in the folder of a recording.
        recordings = {PurePosixPath(name).parent for name in manifest.files} - {*map(PurePosixPath, NO_RECORDINGS)}
        for name in added_files(folder, manifest) if recordings else ():
            if PurePosixPath(name).parent in recordings:
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
