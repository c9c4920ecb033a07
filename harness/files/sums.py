"""``SHA256SUMS``: the digests of files that were made from others, as ``sha256sum --check`` reads them.

A file of that name that somebody else wrote stays as it is. The harness believes none of its lines, and keeps no
digests in that folder.
"""

import hashlib
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from harness.files.bounded import digest_of, read_text
from harness.files.names import is_plain
from harness.files.whole_file import write_whole

SUMS = "SHA256SUMS"
FIRST_LINE = "# harness made these files from others"
"""It says whose list it is; ``sha256sum`` takes it for a comment."""
_LINE = re.compile(r"([0-9a-f]{64})  (.+)")
_EARLIER = re.compile(r"report\.html|results\.parquet|scores[\w.-]*")
"""The names in lists of version 0.1, which had no such line."""


def note_made(path: Path) -> None:
    """Write the digest of a file that was just made beside it, in place of an earlier one.

    Raises:
        OSError: It cannot be written.
    """
    if (told := _sums(path.parent)) is not None:
        there = {name: it for name, it in told.items() if (path.parent / name).is_file()}
        write_whole(path.parent / SUMS, _text_of({**there, path.name: digest_of(path)}))


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


def forget_made(path: Path) -> None:
    """Take a file out of the list beside it, which is whole after that; an empty list is removed.

    Raises:
        OSError: It cannot be written.
    """
    told = _sums(path.parent)
    if told is None:
        return
    told.pop(path.name, None)
    if told:
        write_whole(path.parent / SUMS, _text_of(told))
    else:
        (path.parent / SUMS).unlink(missing_ok=True)


def read_sums(folder: Path) -> dict[str, str]:
    """The digests in a folder's ``SHA256SUMS``, by the name of a file there.

    Lines that name no file of the folder are left out, and so is a foreign list.
    """
    return _sums(folder) or {}


def changed_since_made(folder: Path) -> list[str]:
    """Names of the files in `folder` that are not what was made; ``SHA256SUMS`` too, if that is damaged itself."""
    sums, path = _sums(folder), folder / SUMS
    if sums is None:
        return []
    changed = [name for name, digest in sums.items() if not _is(folder / name, digest)]
    whole = [_text_of(sums), _text_of(sums).removeprefix(f"{FIRST_LINE}\n")]
    if path.exists() and not any(_is(path, hashlib.sha256(text.encode()).hexdigest()) for text in whole):
        changed.append(SUMS)
    return changed


def _sums(folder: Path) -> dict[str, str] | None:
    """See `read_sums`; None where somebody else wrote the list."""
    try:
        lines = read_text(folder / SUMS).splitlines()
    except (OSError, UnicodeDecodeError):
        lines = []  # not there, or damaged: what it told of can be made again
    told = {found[2]: found[1] for found in map(_LINE.fullmatch, lines) if found and is_plain(found[2])}
    return told if lines[:1] == [FIRST_LINE] or all(map(_EARLIER.fullmatch, told)) else None


def _text_of(sums: Mapping[str, str]) -> str:
    return f"{FIRST_LINE}\n" + "".join(f"{digest}  {name}\n" for name, digest in sorted(sums.items()))


def _is(path: Path, digest: str) -> bool:
    return path.is_file() and not path.is_symlink() and digest_of(path) == digest
