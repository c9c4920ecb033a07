"""Files and folders by a pattern that a user typed."""

import glob
import os
from collections.abc import Iterable
from pathlib import Path

from harness.errors import UsageError


def matched_paths(patterns: str | Iterable[str], *, folders: bool = False) -> list[Path]:
    """The files that a pattern, or any of several, matches: sorted, each once; ``**`` stands for any folders.

    Args:
        patterns: The names of files, or patterns of them.
        folders: Whether a pattern that matches no file may match folders.

    Raises:
        UsageError: A pattern matches nothing.
    """
    given = [patterns] if isinstance(patterns, str) else list(patterns)
    return sorted({path for pattern in given for path in _matched(pattern, folders)})


def _matched(pattern: str, folders: bool) -> list[Path]:
    path = Path(os.path.expanduser(pattern))  # no error, whatever the text
    if os.path.isfile(path) or (folders and os.path.isdir(path)):  # a name may hold [ or *
        return [path]
    matched = [Path(name) for name in glob.glob(str(path), recursive=True)]
    files = [name for name in matched if os.path.isfile(name)]
    if files or (folders and matched):
        return files or matched
    only = "; it matches folders only" if matched else ""
    raise UsageError(f"No file matches '{pattern}'{only}. Quote a pattern, as in 'runs/*.csv'")
