"""The key of this user on this machine. It signs what the harness keeps for itself, and never leaves the machine."""

import os
import secrets
import stat
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

from harness.files.state_folder import state_folder

SIZE = 32
"""Bytes of the key."""


def key_file() -> Path:
    """Where the key is."""
    return state_folder() / "key"


@lru_cache(maxsize=1)  # a report signs and compares thousands of files
def machine_key() -> bytes:
    """The key, made when it is asked for the first time. Where none can be kept, one that ends with this process."""
    try:
        path = key_file()
        return _read(path) or _make(path) or secrets.token_bytes(SIZE)
    except (OSError, RuntimeError):  # no home, or one that allows no writing
        return secrets.token_bytes(SIZE)


def _read(path: Path) -> bytes | None:
    """The key that is there; None if there is none, or one that others may know or have written."""
    try:
        number = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0))
    except OSError:
        return None
    with os.fdopen(number, "rb") as file:
        found = os.fstat(number)
        is_mine = not hasattr(os, "getuid") or (found.st_uid == os.getuid() and not found.st_mode & 0o077)
        content = file.read(SIZE + 1) if is_mine and stat.S_ISREG(found.st_mode) else b""
    return content if len(content) == SIZE else None


def _make(path: Path) -> bytes | None:
    """Make a key, unless another process is quicker; None if something else stands in its place."""
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    partial = path.with_name(f".key.{os.getpid()}.{secrets.token_hex(4)}")
    number = os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    try:
        with os.fdopen(number, "wb") as file:
            file.write(secrets.token_bytes(SIZE))
        with suppress(FileExistsError):  # another process was quicker: its key is read below
            os.link(partial, path)
    finally:
        partial.unlink()
    return _read(path)
