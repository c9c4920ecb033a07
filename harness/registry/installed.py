"""The entry points of what is installed."""

import os
import sys
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points


def installed(group: str) -> tuple[EntryPoint, ...]:
    """The entry points of a group, of all installed distributions.

    To look for them opens a file of every distribution. It is done again where Python searches elsewhere, and where
    something was installed or removed since, which changes the folder.
    """
    return _entry_points(group, tuple((folder, _changed(folder)) for folder in map(os.path.abspath, sys.path)))


@lru_cache(maxsize=4)
def _entry_points(group: str, _: tuple[tuple[str, int], ...]) -> tuple[EntryPoint, ...]:
    return tuple(entry_points(group=group))


def _changed(folder: str) -> int:
    """When a folder's list of names changed last, [ns]; 0 of what is none."""
    try:
        return os.stat(folder).st_mtime_ns
    except OSError:
        return 0
