"""``SHA256SUMS``: the digests of files that were made from others, as ``sha256sum --check`` reads them."""

import hashlib
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from harness.files.bounded import digest_of, read_text
from harness.files.whole_file import write_whole

SUMS = "SHA256SUMS"
_LINE = re.compile(r"([0-9a-f]{64})  ([^/\\\n]+)")


def note_made(path: Path) -> None:
    """Write the digest of a file that was just made beside it, in place of an earlier one.

    Raises:
        OSError: It cannot be written.
    """
    told = {**read_sums(path.parent), path.name: digest_of(path)}
    there = {name: digest for name, digest in told.items() if (path.parent / name).is_file()}
    write_whole(path.parent / SUMS, _text_of(there))


@contextmanager
def making(path: Path) -> Iterator[None]:
    """Within this a file is made in place of an earlier one; then `note_made`.

    Killed at any moment, this leaves no digest of another file than the one that is there.

    Raises:
        OSError: The digests cannot be written.
    """
    told = read_sums(path.parent)
    if told.pop(path.name, None) is not None:
        write_whole(path.parent / SUMS, _text_of(told))
    yield
    note_made(path)


def read_sums(folder: Path) -> dict[str, str]:
    """The digests in a folder's ``SHA256SUMS``, by name; lines that are none are left out."""
    try:
        lines = read_text(folder / SUMS).splitlines()
    except (OSError, UnicodeDecodeError):
        return {}  # not there, or damaged: what it told of can be made again
    return {found[2]: found[1] for found in map(_LINE.fullmatch, lines) if found}


def changed_since_made(folder: Path) -> list[str]:
    """Names of the files in `folder` that are not what was made; ``SHA256SUMS`` too, if that is damaged itself."""
    sums, path = read_sums(folder), folder / SUMS
    changed = [name for name, digest in sums.items() if not _is(folder / name, digest)]
    if path.exists() and not _is(path, hashlib.sha256(_text_of(sums).encode()).hexdigest()):
        changed.append(SUMS)
    return changed


def _text_of(sums: Mapping[str, str]) -> str:
    return "".join(f"{digest}  {name}\n" for name, digest in sorted(sums.items()))


def _is(path: Path, digest: str) -> bool:
    return path.is_file() and not path.is_symlink() and digest_of(path) == digest
