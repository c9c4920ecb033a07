"""A folder that a user names with ``--out``: how it is made, and kept to one program at a time."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from harness.errors import StorageError, UsageError
from harness.record.folder import CHECKPOINT


@contextmanager
def folder_lock(path: Path, problem: str, on_wait: Callable[[], None] | None = None) -> Iterator[None]:
    """Hold the lock file at `path`; the system lets go of it when this process ends, however it ends.

    Args:
        path: The lock file, made if it is not there; it stays.
        problem: What to say if another process holds it.
        on_wait: Wait for the other process; this is called first. None: do not wait.

    Raises:
        UsageError: Another process holds it.
    """
    from filelock import FileLock, Timeout  # only who writes waits for the import

    lock = FileLock(path)
    try:
        held = lock.acquire(timeout=0)
    except Timeout:
        if on_wait is None:
            raise UsageError(f"{problem}: wait for it, or name another --out") from None
        on_wait()
        held = lock.acquire()
    with held:
        yield


def is_held(path: Path) -> bool:
    """Whether another process holds the lock file at `path`. Nothing is opened to be written, and no link is followed.

    On a system without ``flock`` nobody can tell without writing: False.
    """
    try:
        import fcntl
    except ImportError:
        return False
    try:
        number = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return False  # it is not there, or a link
    with os.fdopen(number) as file:
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)  # a shared one: two who look do not disturb each other
        except OSError:
            return True
    return False


@contextmanager
def storage_errors(folder: Path) -> Iterator[None]:
    """What the system refuses while a folder is written becomes one line.

    Raises:
        StorageError: The disk is full or fails, too many files are open, or the folder is gone.
    """
    try:
        yield
    except BrokenPipeError:
        raise  # who read what is printed is gone: nothing is wrong with the folder
    except OSError as error:
        if isinstance(error, FileNotFoundError) and not folder.exists():
            raise StorageError(
                f"'{folder}' is gone: somebody removed or renamed it meanwhile. Put it back, or run the same command "
                "to begin anew"
            ) from error
        raise StorageError(
            f"'{folder}' cannot be written: {error.strerror or error}. "
            "What is done is kept. Solve that, then run the same command to go on"
        ) from error


def require_text(folder: Path, noun: str = "--out") -> None:
    """See that a folder's path is text: libraries that write into it take nothing else.

    Raises:
        UsageError: It holds bytes that are not UTF-8.
    """
    try:
        str(folder).encode()
    except UnicodeEncodeError:
        raise UsageError(
            f"{noun} '{folder}' is not written in UTF-8, which files in it need: give another name"
        ) from None


def make_folder(folder: Path, inner: str = "") -> None:
    """Make the folder that a user named, or see whether the one that is there can be written into.

    Args:
        folder: Named with ``--out``.
        inner: A folder in it that is made too.

    Raises:
        UsageError: It cannot be made or written into, or is not written in UTF-8.
    """
    require_text(folder)
    existing = next(parent for parent in [folder, *folder.absolute().parents] if parent.exists())
    if not existing.is_dir() or not os.access(existing, os.W_OK | os.X_OK):
        raise UsageError(f"--out '{folder}' cannot be written: '{existing}' allows no writing here")
    try:
        (folder / inner).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"--out '{folder}' cannot be made: {error.strerror}. Name another folder") from None


def refuse_links(folder: Path, rule: str = "nothing is written into a folder with links") -> None:
    """See that nothing in a folder leads out of it: what is written there could land elsewhere.

    A file with a second name is a link too, where a run would write on in it. All others are replaced.

    Args:
        folder: To look through.
        rule: What the message says is not done.

    Raises:
        UsageError: There is such a link in it; the message names it.
    """
    for parent, folders, files in os.walk(folder):
        goes_on = CHECKPOINT in files or Path(parent).name.startswith(".")
        for name in (*folders, *files):
            path = Path(parent) / name
            has_names = goes_on and name in files and path.lstat().st_nlink > 1
            if path.is_symlink() or has_names:
                raise UsageError(f"'{path}' is a link; {rule}: remove it")
