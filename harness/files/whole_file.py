"""Files that are there completely or not at all, whatever happens to the process that writes them."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

PARTIAL = ".partial"
"""The end of the name of a file that is not complete; such a name begins with a dot."""


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A place beside `path` to write to; what is written there takes the place of `path` when the block ends.

    A reader finds the old file or the new one, whole. When an exception passes, the old one stays. A link at `path` is
    replaced, not followed.

    Raises:
        OSError: The file cannot take its place.
    """
    with whole_files(path.parent, [path.name]) as (partial,):
        yield partial


@contextmanager
def whole_files(folder: Path, names: Sequence[str], is_lasting: bool = True) -> Iterator[list[Path]]:
    """The same for several files of one folder. They take their places in this order, and all are written by then.

    Args:
        folder: Where they belong.
        names: Of the files.
        is_lasting: They also survive a machine that stops. That takes the disk some milliseconds for each file.

    Raises:
        OSError: One of them cannot take its place; those before it have.
    """
    partials = [folder / f".{name}.{os.getpid()}{PARTIAL}" for name in names]
    for partial in partials:
        partial.unlink(missing_ok=True)  # of a killed process with this number, or a link that somebody laid there
    try:
        yield partials
        if is_lasting:
            for partial in partials:
                sync(partial)  # else a machine that stops could leave the new name on an empty file
        for partial, name in zip(partials, names, strict=True):
            os.replace(partial, folder / name)
        if is_lasting:
            sync(folder)
    finally:
        for partial in partials:
            with suppress(OSError):  # gone if it took its place, never there if it could not be written
                partial.unlink()


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file, text as UTF-8; see `whole_file`."""
    with whole_file(path) as partial:
        partial.write_bytes(content.encode() if isinstance(content, str) else content)


def is_partial(path: Path) -> bool:
    """Whether a process that was killed left it half written."""
    return path.name.startswith(".") and path.name.endswith(PARTIAL)


def files_in(folder: Path) -> list[Path]:
    """All files in a folder and in the folders in it, in order. Links to folders are not followed."""
    return sorted(Path(place) / name for place, _, names in os.walk(folder) for name in names)


def sync(path: Path) -> None:
    """Have the system write a file, or the names in a folder, to the disk.

    Raises:
        OSError: It cannot.
    """
    if path.is_dir() and os.name == "nt":
        return  # Windows opens no folder
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)
