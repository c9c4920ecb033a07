"""A file of keys and values that a user writes."""

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from harness.errors import UsageError, sentence
from harness.files.bounded import read_text
from harness.registry.spec import nothing_at
from harness.text import one_line

NONE: Mapping[str, Any] = MappingProxyType({})

MOST_BYTES = 2**19
"""The most bytes of a file: an experiment with a list of 10,000 seeds has a fifth of it."""
MOST_DEPTH = 20
"""Tables and lists within one another; ours have four."""

_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_DEEP_KEY = re.compile(rf"(?<![\w-]){_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{MOST_DEPTH}}}")
"""A key of many parts, ``a.b.c``: tomllib takes minutes over one of 100,000 parts, so it is looked for before."""


def read_toml(path: Path, noun: str, overrides: Mapping[str, Any] = NONE) -> dict[str, Any]:
    """The keys of a TOML file; an override wins over a key of the file.

    Args:
        path: The file.
        noun: What to call it, ``experiment file``.
        overrides: Keys that are given beside the file.

    Raises:
        UsageError: There is no such file, it cannot be read or is too large, or it is no TOML.
    """
    try:
        return {**_read(path), **overrides}
    except FileNotFoundError:
        raise UsageError(nothing_at(path, noun)) from None
    except (OSError, ValueError) as error:
        problem = error.strerror if isinstance(error, OSError) and error.strerror else one_line(str(error))
        raise UsageError(f"{sentence(noun)} '{path}' cannot be read: {problem}. Give a TOML file in UTF-8.") from None


def _read(path: Path) -> dict[str, Any]:
    text = read_text(path, MOST_BYTES).removeprefix("\ufeff")  # a mark that some editors write before all else
    too_deep = ValueError(f"its tables are nested too deeply, {MOST_DEPTH} within one another are allowed")
    if _DEEP_KEY.search(text):
        raise too_deep
    try:
        keys = tomllib.loads(text)
    except RecursionError:
        raise too_deep from None
    if depth_of(keys) > MOST_DEPTH:
        raise too_deep
    return keys


def depth_of(keys: dict[str, Any]) -> int:
    """How many tables and lists lie within one another; counted no further than is of interest."""
    depth = 0
    level: list[Any] = [keys]
    while level and depth <= MOST_DEPTH:
        depth += 1
        held = [item for part in level for item in (part.values() if isinstance(part, dict) else part)]
        level = [item for item in held if isinstance(item, dict | list)]
    return depth
