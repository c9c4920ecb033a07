"""JSON files that carry the SHA-256 of their own bytes: a flipped bit is found, whichever it is."""

import hashlib
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from harness.errors import NewerFormat
from harness.files.bounded import TEXT_BYTES, parse_json, read_bytes, reading

KEY = "digest"
_LAST = re.compile(rb'"digest": "([0-9a-f]{64})"\n}\n\Z')
_EMPTY = b'"digest": ""\n}\n'
_NUMBERS = re.compile(r"\[\n\s+([^][{}\"]+?)\n\s+\]")
"""A list without texts, lists and objects in it; no text in JSON holds the end of a line."""


def seal(content: Mapping[str, Any], is_flat: bool = False) -> bytes:
    """The JSON text of `content`, whose last key is the SHA-256 of the text with that key empty.

    Args:
        content: Plain data.
        is_flat: Write a list of numbers on one line.
    """
    indented = json.dumps({**content, KEY: ""}, indent=1, allow_nan=False)
    flat = _NUMBERS.sub(lambda found: f"[{' '.join(found[1].split())}]", indented) if is_flat else indented
    text = f"{flat}\n".encode()
    return text[: -len(_EMPTY)] + f'"{KEY}": "{hashlib.sha256(text).hexdigest()}"\n}}\n'.encode()


def unseal(text: bytes) -> dict[str, Any]:
    """The content that `seal` wrote, the digest left out.

    Raises:
        ValueError: It is not what was written.
    """
    _require_whole(text)
    content: dict[str, Any] = parse_json(text)
    del content[KEY]
    return content


def _require_whole(text: bytes) -> None:
    found = _LAST.search(text)
    if found is None:
        raise ValueError("its digest is missing")
    if hashlib.sha256(text[: found.start()] + _EMPTY).hexdigest().encode() != found[1]:
        raise ValueError("it is not what was written: its digest differs")


def read_sealed(path: Path, noun: str, newest: int, since: int, most: int = TEXT_BYTES) -> dict[str, Any]:
    """The object in a JSON file with the key ``format``; sealed, if its format is `since` or newer.

    Args:
        path: The file.
        noun: What it should be, ``manifest``.
        newest: The newest format that can be read; a file without the key has format 1.
        since: The first format that is sealed.
        most: Bytes that it may have.

    Raises:
        SchemaError: It cannot be read, is no JSON object, or is not what was written.
        NewerFormat: A newer version wrote it.
    """
    with reading(path, noun):
        text = read_bytes(path, most)
        content = parse_json(text)
        if not isinstance(content, dict):
            raise ValueError("it holds no object")
        number = content.get("format", 1)
        if not isinstance(number, int):
            raise ValueError(f"its format is {number!r}")
        if number > newest:
            raise NewerFormat(f"{path} has format {number}, this version reads up to {newest}")
        if number >= since or KEY in content:
            _require_whole(text)
            del content[KEY]
        return content
