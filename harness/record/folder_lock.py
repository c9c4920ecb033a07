"""Keeps two programs from writing into one folder at once, on every system."""

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
