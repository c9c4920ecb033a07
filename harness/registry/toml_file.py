"""A file of keys and values that a user writes."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from harness.errors import UsageError, sentence

NONE: Mapping[str, Any] = MappingProxyType({})


def read_toml(path: Path, noun: str, overrides: Mapping[str, Any] = NONE) -> dict[str, Any]:
    """The keys of a TOML file; an override wins over a key of the file.

    Args:
        path: The file.
        noun: What to call it, ``experiment file``.
        overrides: Keys that are given beside the file.

    Raises:
        UsageError: There is no such file, it cannot be read, or it is no TOML.
    """
    try:
        return {**tomllib.loads(path.read_text(encoding="utf-8")), **overrides}
    except FileNotFoundError:
        raise UsageError(f"No {noun} '{path}'") from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise UsageError(f"{sentence(noun)} '{path}' cannot be read: {error}. Give a TOML file in UTF-8.") from None
