"""Frozen dataclasses as plain data."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from itertools import repeat
from pathlib import Path
from types import UnionType
from typing import Any, Self, cast, get_args, get_origin, get_type_hints


class Plain:
    """What gives a dataclass `to_json` and `from_json`, field by field."""

    def to_json(self) -> dict[str, Any]:
        """Plain data; `from_json` gives the same back."""
        return {field.name: to_plain(getattr(self, field.name)) for field in fields(cast(Any, self))}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """What `to_json` told, also after a way through JSON; a key that is missing has its default."""
        return cls(
            **{name: from_plain(kind, data[name]) for name, kind in _kinds(cast(Any, cls)).items() if name in data}
        )


def to_plain(value: Any) -> Any:
    """A field's value as plain data: lists for tuples and sets, text for paths."""
    if hasattr(value, "to_json"):
        return value.to_json()
    if isinstance(value, frozenset):
        return sorted(value)
    if isinstance(value, tuple):
        return [to_plain(item) for item in value]
    return str(value) if isinstance(value, Path) else value


def from_plain(kind: Any, data: Any) -> Any:
    """The value of a type that `to_plain` told."""
    if get_origin(kind) is UnionType and isinstance(data, list):
        kind = next((part for part in get_args(kind) if get_origin(part) is tuple), kind)
    parts = get_args(kind)
    if hasattr(kind, "from_json"):
        return kind.from_json(data)
    if get_origin(kind) is frozenset:
        return frozenset(data)
    if get_origin(kind) is tuple:
        return tuple(map(from_plain, repeat(parts[0]) if parts[1:] == (...,) else parts, data))
    if isinstance(data, Mapping):  # one of several dataclasses: that which has these fields
        dataclasses = filter(is_dataclass, parts)
        kind = next((part for part in dataclasses if data.keys() <= _kinds(cast(Any, part)).keys()), kind)
        return from_plain(kind, data) if hasattr(kind, "from_json") else data
    return Path(data) if kind is Path else data


@cache
def _kinds(target: Any) -> dict[str, Any]:
    """The types of a dataclass's fields, by name."""
    hints = get_type_hints(target)
    return {field.name: hints[field.name] for field in fields(target)}
