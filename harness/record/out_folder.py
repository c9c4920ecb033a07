"""A folder that a user names with ``--out``: how it is made, and kept to one program at a time."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from harness.errors import UsageError


@contextmanager
def folder_lock(path: Path, problem: str) -> Iterator[None]:
    """Hold the lock file at `path`; the system lets go of it when this process ends, however it ends.

    Args:
        path: The lock file, made if it is not there; it stays.
        problem: What to say if another process holds it.

    Raises:
        UsageError: Another process holds it.
    """
    from filelock import FileLock, Timeout  # only who writes waits for the import

    try:
        lock = FileLock(path).acquire(timeout=0)
    except Timeout:
        raise UsageError(f"{problem}: wait for it, or name another --out") from None
    with lock:
        yield


def make_folder(folder: Path, inner: str = "") -> None:
    """Make the folder that a user named, or see whether the one that is there can be written into.

    Args:
        folder: Named with ``--out``.
        inner: A folder in it that is made too.

    Raises:
        UsageError: It cannot be made or written into.
    """
    existing = next(parent for parent in [folder, *folder.absolute().parents] if parent.exists())
    if not existing.is_dir() or not os.access(existing, os.W_OK | os.X_OK):
        raise UsageError(f"--out '{folder}' cannot be written: '{existing}' allows no writing here")
    try:
        (folder / inner).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"--out '{folder}' cannot be made: {error.strerror}. Name another folder") from None
