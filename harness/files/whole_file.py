"""Files that are there completely or not at all, whatever happens to the process that writes them."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

PARTIAL = ".partial"
"""The end of the name of a file that is not complete; such a name begins with a dot."""


@contextmanager
def whole_file(path: Path, *, synced: bool = True) -> Iterator[Path]:
    """A place beside `path` to write to; what is written there takes the place of `path` when the block ends.

    A reader finds the old file or the new one, whole. When an exception passes, the old one stays. A link at `path` is
    replaced, not followed.

    Args:
        path: The file.
        synced: Whether to wait for the disk. A machine that stops may leave a file empty that was not synced.

    Raises:
        OSError: The file cannot take its place.
    """
    partial = path.with_name(f".{path.name}.{os.getpid()}{PARTIAL}")
    partial.unlink(missing_ok=True)  # of a killed process with this number, or a link that somebody laid there
    try:
        yield partial
        if synced:
            sync(partial)
        os.replace(partial, path)
        if synced:
            sync(path.parent)
    finally:
        with suppress(OSError):  # gone if it took its place, never there if it could not be written
            partial.unlink()


def write_whole(path: Path, content: str | bytes, *, synced: bool = True) -> None:
    """Write a file, text as UTF-8; see `whole_file`."""
    with whole_file(path, synced=synced) as partial:
        partial.write_bytes(content.encode() if isinstance(content, str) else content)


def is_partial(path: Path) -> bool:
    """Whether a process that was killed left it half written."""
    return path.name.startswith(".") and path.name.endswith(PARTIAL)


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
