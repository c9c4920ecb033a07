"""Files that are there completely or not at all, whatever happens to the process that writes them."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

PARTIAL = ".partial"
"""The end of the name of a file that is not complete; such a name begins with a dot."""


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A place beside `path` to write to; what is written there takes the place of `path` when the block ends.

    A reader finds the old file or the new one, whole. When an exception passes, the old one stays.

    Raises:
        OSError: The file cannot take its place.
    """
    partial = path.with_name(f".{path.name}.{os.getpid()}{PARTIAL}")
    try:
        yield partial
        with partial.open("rb+") as file:
            os.fsync(file.fileno())  # else a machine that stops could leave the new name on an empty file
        os.replace(partial, path)
    finally:
        with suppress(OSError):  # gone if it took its place, never there if it could not be written
            partial.unlink()


def write_whole(path: Path, text: str) -> None:
    """Write a text file, UTF-8; see `whole_file`."""
    with whole_file(path) as partial:
        partial.write_text(text, encoding="utf-8")


def is_partial(path: Path) -> bool:
    """Whether a process that was killed left it half written."""
    return path.name.startswith(".") and path.name.endswith(PARTIAL)
