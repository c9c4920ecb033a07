"""Files that say themselves whether they are whole, and whose they are: for what can be made again."""

import hashlib
from pathlib import Path

from harness.files.bounded import read_bytes
from harness.files.whole_file import write_whole

_LINE = 65
"""Bytes of the first line: a SHA-256 in hexadecimal, and its end."""


def write_sealed(path: Path, key: str, content: bytes) -> None:
    """Write a file that `read_sealed` gives back under the same key alone.

    Raises:
        OSError: It cannot be written.
    """
    write_whole(path, seal(key, content) + content)


def read_sealed(path: Path, key: str, most: int) -> bytes | None:
    """What was written under `key`.

    None where nothing can be read there, nothing of at most `most` bytes, or something that was not written whole under
    this key: the caller makes it again.
    """
    try:
        found = read_bytes(path, most)
    except OSError:
        return None
    line, content = found[:_LINE], found[_LINE:]
    return content if line == seal(key, content) else None


def seal(key: str, content: bytes) -> bytes:
    """The first line of such a file."""
    digest = hashlib.sha256(key.encode() + b"\0")
    digest.update(content)
    return digest.hexdigest().encode() + b"\n"
