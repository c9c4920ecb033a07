"""Frozen dataclasses as plain data, and files that say whether they are what was written: sealed, keyed, listed."""

import hashlib
import hmac
import json
import os
import re
import secrets
import stat
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import fields, is_dataclass
from functools import cache, lru_cache
from itertools import repeat
from pathlib import Path
from types import UnionType
from typing import Any, Self, cast, get_args, get_origin, get_type_hints

from harness.errors import NewerFormat
from harness.files.bounded import (
    TEXT_BYTES,
    digest_of,
    is_plain,
    parse_json,
    read_bytes,
    read_text,
    reading,
    whole_files,
    write_whole,
)


class Plain:
    """What gives a dataclass `to_json` and `from_json`, field by field."""

    def to_json(self) -> dict[str, Any]:
        """Plain data; `from_json` gives the same back."""
        return {field.name: to_plain(getattr(self, field.name)) for field in fields(cast(Any, self))}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """What `to_json` told, also after a way through JSON; a key that is missing has its default."""
        return cls(
            **{name: from_plain(kind, data[name]) for name, kind in _kinds(cast(Any, cls)).items() if name in data}
        )


def to_plain(value: Any) -> Any:
    """A field's value as plain data: lists for tuples and sets, text for paths."""
    if hasattr(value, "to_json"):
        return value.to_json()
    if isinstance(value, frozenset):
        return sorted(value)
    if isinstance(value, tuple):
        return [to_plain(item) for item in value]
    return str(value) if isinstance(value, Path) else value


def from_plain(kind: Any, data: Any) -> Any:
    """The value of a type that `to_plain` told."""
    if get_origin(kind) is UnionType and isinstance(data, list):
        kind = next((part for part in get_args(kind) if get_origin(part) is tuple), kind)
    parts = get_args(kind)
    if hasattr(kind, "from_json"):
        return kind.from_json(data)
    if get_origin(kind) is frozenset:
        return frozenset(data)
    if get_origin(kind) is tuple:
        return tuple(map(from_plain, repeat(parts[0]) if parts[1:] == (...,) else parts, data))
    if isinstance(data, Mapping):  # one of several dataclasses: that which has these fields
        dataclasses = filter(is_dataclass, parts)
        kind = next((part for part in dataclasses if data.keys() <= _kinds(cast(Any, part)).keys()), kind)
        return from_plain(kind, data) if hasattr(kind, "from_json") else data
    return Path(data) if kind is Path else data


@cache
def _kinds(target: Any) -> dict[str, Any]:
    """The types of a dataclass's fields, by name."""
    hints = get_type_hints(target)
    return {field.name: hints[field.name] for field in fields(target)}


KEY = "digest"
_LAST = re.compile(rb'"digest": "([0-9a-f]{64})"\n}\n\Z')
_EMPTY = b'"digest": ""\n}\n'
_NUMBERS = re.compile(r"\[\n\s+([^][{}\"]+?)\n\s+\]")
"""A list without texts, lists and objects in it; no text in JSON holds the end of a line."""


def seal(content: Mapping[str, Any], is_flat: bool = False) -> bytes:
    """The JSON text of `content`, whose last key is the SHA-256 of the text with that key empty.

    Args:
        content: Plain data.
        is_flat: Write a list of numbers on one line.
    """
    indented = json.dumps({**content, KEY: ""}, indent=1, allow_nan=False)
    flat = _NUMBERS.sub(lambda found: f"[{' '.join(found[1].split())}]", indented) if is_flat else indented
    text = f"{flat}\n".encode()
    return text[: -len(_EMPTY)] + f'"{KEY}": "{hashlib.sha256(text).hexdigest()}"\n}}\n'.encode()


def unseal(text: bytes) -> dict[str, Any]:
    """The content that `seal` wrote, the digest left out.

    Raises:
        ValueError: It is not what was written.
    """
    _require_whole(text)
    content: dict[str, Any] = parse_json(text)
    del content[KEY]
    return content


def _require_whole(text: bytes) -> None:
    found = _LAST.search(text)
    if found is None:
        raise ValueError("its digest is missing")
    if hashlib.sha256(text[: found.start()] + _EMPTY).hexdigest().encode() != found[1]:
        raise ValueError("it is not what was written: its digest differs")


def read_sealed(path: Path, noun: str, newest: int, since: int, most: int = TEXT_BYTES) -> dict[str, Any]:
    """The object in a JSON file with the key ``format``; sealed, if its format is `since` or newer.

    Args:
        path: The file.
        noun: What it should be, ``manifest``.
        newest: The newest format that can be read; a file without the key has format 1.
        since: The first format that is sealed.
        most: Bytes that it may have.

    Raises:
        SchemaError: It cannot be read, is no JSON object, or is not what was written.
        NewerFormat: A newer version wrote it.
    """
    with reading(path, noun):
        text = read_bytes(path, most)
        content = parse_json(text)
        if not isinstance(content, dict):
            raise ValueError("it holds no object")
        number = content.get("format", 1)
        if not isinstance(number, int):
            raise ValueError(f"its format is {number!r}")
        if number > newest:
            raise NewerFormat(f"{path} has format {number}, this version reads up to {newest}")
        if number >= since or KEY in content:
            _require_whole(text)
            del content[KEY]
        return content


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
