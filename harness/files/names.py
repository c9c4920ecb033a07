"""Names that stand in a file and become paths: whether they stay in the folder that names them, on every system."""

import unicodedata
from collections.abc import Iterable

LONGEST = 255
"""The most bytes of the name of a file, on most systems."""


def is_plain(name: str) -> bool:
    r"""Whether a name is that of a file or folder in the folder that names it, and in no other place.

    ``..``, ``.``, ``a/b``, ``a\b``, ``C:a``, and names that are empty, too long, or hold a character that no text has,
    are not.
    """
    if name in ("", ".", "..") or any(char in name for char in "/\\:"):
        return False
    if any(unicodedata.category(char) in ("Cc", "Cs") for char in name):
        return False
    return len(name.encode()) <= LONGEST


def is_inside(path: str) -> bool:
    """Whether a path, its parts between slashes, leads to a file in the folder that names it, or below."""
    return all(map(is_plain, path.split("/")))


def twins(paths: Iterable[str]) -> list[str]:
    """The paths that some systems take for another one of the list: its case or its accents are written otherwise."""
    known: dict[str, str] = {}
    return [path for path in paths if known.setdefault(_on_any_system(path), path) != path]


def _on_any_system(path: str) -> str:
    return unicodedata.normalize("NFC", unicodedata.normalize("NFC", path).casefold())
