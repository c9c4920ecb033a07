"""Reads files that anybody may have made: regular ones alone, of a bounded size; JSON that ends somewhere."""

import errno
import hashlib
import json
import math
import os
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from harness.errors import HarnessError, SchemaError, one_line
from harness.files.file_kind import HEAD, FileKind, kind_of

TEXT_BYTES = 16 * 2**20
"""Most that is read of a file that people or programs write as text, unless a reader says otherwise."""


@contextmanager
def open_regular(path: Path, most: int) -> Iterator[BinaryIO]:
    """A regular file, open for reading: no pipe that hangs, no device that never ends. A link to one is followed.

    Args:
        path: The file.
        most: Bytes that it may have.

    Raises:
        OSError: It is not there, cannot be read, is no regular file or is too large.
    """
    # Without O_NONBLOCK a pipe that nobody writes to would hold us here.
    number = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    with os.fdopen(number, "rb") as file:
        found = os.fstat(number)
        if not stat.S_ISREG(found.st_mode):
            raise OSError(errno.EINVAL, "it is no regular file", str(path))
        if found.st_size > most:
            raise OSError(errno.EFBIG, f"it has {found.st_size:,} bytes, {most:,} are allowed", str(path))
        yield file


def require_regular(path: Path, most: int) -> None:
    """See whether a library may open a file by its name; see `open_regular`."""
    with open_regular(path, most):
        pass


def kind_at(path: Path) -> FileKind | None:
    """What a file is by its first bytes; None for text, for what is not known, and where it cannot be read."""
    try:
        with open_regular(path, sys.maxsize) as file:
            head = file.read(HEAD)
    except OSError:
        return None
    return kind_of(head, path)


def read_bytes(path: Path, most: int = TEXT_BYTES) -> bytes:
    """All of a regular file; see `open_regular`."""
    with open_regular(path, most) as file:
        return file.read()


def read_text(path: Path, most: int = TEXT_BYTES) -> str:
    """All of a regular file in UTF-8; see `open_regular`.

    Raises:
        UnicodeDecodeError: It is not in UTF-8.
    """
    return read_bytes(path, most).decode("utf-8")


def read_json(path: Path, most: int = TEXT_BYTES) -> Any:
    """The content of a JSON file; see `open_regular`.

    Raises:
        ValueError: It is no JSON, is nested too deeply, or holds NaN or an infinity, which JSON does not have.
    """
    return parse_json(read_bytes(path, most))


def parse_json(text: bytes) -> Any:
    """What a JSON text in UTF-8 says.

    Raises:
        ValueError: As `read_json`.
    """
    try:
        return json.loads(text.decode("utf-8"), parse_constant=_refuse, parse_float=_finite)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


def _finite(number: str) -> float:
    value = float(number)
    if not math.isfinite(value):
        raise ValueError(f"it holds {number}, which is beyond all numbers")
    return value


def _refuse(constant: str) -> Any:
    raise ValueError(f"it holds {constant}, which is no JSON")


@contextmanager
def reading(path: Path, noun: str, kind: type[HarnessError] = SchemaError) -> Iterator[None]:
    """Whatever a reader lets through becomes one line that names the file, and what it is if that is something else.

    Args:
        path: What is read.
        noun: What it should be, ``trace``.
        kind: What is raised; `UsageError` where a user named the file.

    Raises:
        SchemaError: The block raised something else than a `HarnessError`; or `kind`, where it is another.
    """
    try:
        yield
    except HarnessError:
        raise
    except Exception as error:  # readers of other people's bytes raise anything
        found = kind_at(path)
        is_other = found is not None and noun not in found.name and not path.name.lower().endswith(found.endings)
        reason = f"it is {found.sentence}" if found is not None and is_other else one_line(error)
        raise kind(f"{path} is no readable {noun}: {reason}") from error


def digest_of(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
