"""Splits a folder's files into parts that fit into messages, to send a cell's folder to another machine."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

PART_BYTES = 4 * 2**20


class Part(NamedTuple):
    """A piece of a file. The parts of a file come one after the other."""

    path: str
    """The file's path in the folder, with slashes."""
    content: bytes


def parts_of(folder: Path) -> Iterator[Part]:
    """All files in a folder, in parts. Links and folders without a file are left out."""
    for path in sorted(folder.rglob("*")):
        if path.is_file() and not path.is_symlink():
            yield from _parts_of_file(path, path.relative_to(folder).as_posix())


def _parts_of_file(path: Path, name: str) -> Iterator[Part]:
    with path.open("rb") as file:
        content = file.read(PART_BYTES)
        yield Part(name, content)  # of an empty file too
        while content := file.read(PART_BYTES):
            yield Part(name, content)


def add_part(folder: Path, part: Part) -> None:
    """Append a part to its file in a folder."""
    path = folder / part.path
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("ab") as file:
        file.write(part.content)


def add_parts(folder: Path, parts: Iterable[Part]) -> None:
    """Append parts to their files in a folder.

    Args:
        folder: It need not be there; nor do folders in it.
        parts: Those of one file in order, as `parts_of` gives them.
    """
    for part in parts:
        add_part(folder, part)
