"""The user's own folder for the jobs of a cluster, whose files are unpickled and run."""

import os
import stat
from pathlib import Path

from harness.errors import UsageError
from harness.files.keyed_file import STATE, state_folder


def private_folder() -> Path:
    """The folder, made if there is none.

    A job's function comes from a pickle, so whoever writes here runs code as the user. The folder is under the home
    folder, which the nodes of a cluster share, and not in the experiment's, into which colleagues may write.

    Raises:
        UsageError: The folder cannot be made, or somebody else may write into it or put another in its place.
    """
    place = state_folder() / "jobs"
    try:
        missing = [folder for folder in (place, *place.parents) if not folder.exists()]
        for folder in reversed(missing):
            folder.mkdir(mode=0o700, exist_ok=True)
        _check_owner(place)
        for folder in place.resolve().parents:
            _check_above(folder)
    except OSError as error:
        raise UsageError(f"{place}: {error.strerror}. Set {STATE} to a folder of yours that all nodes see") from error
    return place


def _check_owner(place: Path) -> None:
    """Refuse a folder that is another user's, or that others than its owner may read or write; also a link."""
    told = place.lstat()
    if not stat.S_ISDIR(told.st_mode):
        raise UsageError(f"{place} is a link. Jobs are unpickled from there: remove it, or set {STATE}")
    if told.st_uid != os.geteuid():
        raise UsageError(f"{place} is another user's. Jobs are unpickled from there: set {STATE} to a folder of yours")
    if told.st_mode & 0o077:
        raise UsageError(f"{place} is open to others. Jobs are unpickled from there: chmod 700 it, or set {STATE}")


def _check_above(folder: Path) -> None:
    """Refuse a folder in which everybody may rename what is not theirs."""
    mode = folder.stat().st_mode
    if mode & stat.S_IWOTH and not mode & stat.S_ISVTX:
        raise UsageError(
            f"{folder} is open to everybody, who could replace the jobs in it: chmod o-w it, or set {STATE}"
        )
