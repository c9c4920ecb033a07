"""Files that say themselves whether they are whole, what they follow from, and whose they are: what can be made again.

Only what this user made on this machine is believed: a file of somebody else could say anything under the right key.
"""

import hashlib
import hmac
import os
import secrets
import stat
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

from harness.files.bounded import read_bytes
from harness.files.whole_file import whole_files

STATE = "XDG_STATE_HOME"
"""The environment variable that names a folder for what programs remember; ``~/.local/state`` without it."""


def state_folder() -> Path:
    """The folder, which may not be there yet.

    Raises:
        RuntimeError: The user has no home folder.
    """
    state = Path(os.environ.get(STATE, ""))
    if not state.is_absolute():  # relative ones are to be ignored, says the standard
        state = Path.home() / ".local" / "state"
    return state / "fd100-harness"


def write_keyed(path: Path, key: str, content: bytes) -> None:
    """Write a file that `read_keyed` gives back under the same key alone, a line of text.

    It is not synced to the disk: `read_keyed` tells a file that a stopped machine left empty, and it is made again.

    Raises:
        OSError: It cannot be written.
    """
    with whole_files(path.parent, [path.name], is_lasting=False) as (partial,):
        partial.write_bytes(with_key(key, content))


def read_keyed(path: Path, key: str, most: int) -> bytes | None:
    """What was written under `key`.

    None where nothing can be read there, nothing of at most `most` bytes, or something that was not written whole under
    this key, by this user on this machine: the caller makes it again.
    """
    try:
        told, _, rest = read_bytes(path, most).partition(b"\n")
    except OSError:
        return None
    signature, _, signed = rest.partition(b"\n")
    own = f"{key}\n".encode()
    is_ours = told == _digest(rest) and hmac.compare_digest(signature, _sign(signed))
    return signed[len(own) :] if is_ours and signed.startswith(own) else None


def is_whole(path: Path, most: int) -> bool:
    """Whether a file is what was written, under whatever key and by whomever."""
    try:
        told, _, rest = read_bytes(path, most).partition(b"\n")
    except OSError:
        return False
    return told == _digest(rest)


def with_key(key: str, content: bytes) -> bytes:
    """The file: lines with the SHA-256 of all behind it, the signature of what follows, and the key; the content."""
    signed = f"{key}\n".encode() + content
    rest = _sign(signed) + b"\n" + signed
    return _digest(rest) + b"\n" + rest


def _sign(content: bytes) -> bytes:
    return hmac.digest(machine_key(), content, "sha256").hex().encode()


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()


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
