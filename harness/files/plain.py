"""Frozen dataclasses and named tuples as plain data: the one place that writes them for JSON and reads them again."""

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from itertools import repeat
from operator import attrgetter
from pathlib import Path
from types import UnionType
from typing import Any, Self, TypeVar, cast, get_args, get_origin, get_type_hints

T = TypeVar("T")

PLAIN = bool, int, float, str, type(None)
"""What JSON has itself."""


def tells(*names: str) -> Callable[[T], T]:
    """Decorate a dataclass or a named tuple that does not tell each of its fields, or more than these.

    Args:
        names: Of fields, properties and class variables, in order. A name may lead on, ``group.steps``. In ``key=name``
            the key is another than the name. Behind a star the value is told without a key of its own: its keys stand
            here, and None has none.
    """

    def mark(kind: Any) -> Any:
        kind.TELLS = names
        return kind

    return mark


class Plain:
    """What gives a dataclass `to_json` and `from_json`."""

    def to_json(self) -> dict[str, Any]:
        """Plain data; `from_json` gives the same back where every field is told."""
        return _told(self)

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """What `to_json` told, also after a way through JSON; a key that is missing has its default."""
        return cast(Self, _made(cls, data))


def to_plain(value: Any) -> Any:
    """A value as plain data: lists for tuples, sets and arrays, text for paths."""
    kind: Any = type(value)
    if kind in PLAIN:  # mostly
        return value
    if hasattr(value, "to_json"):
        return value.to_json()
    if _has_fields(kind):
        return _told(value)
    if isinstance(value, Mapping):
        return {key: to_plain(item) for key, item in value.items()}
    if isinstance(value, tuple | list | frozenset):
        return [to_plain(item) for item in (sorted(value) if isinstance(value, frozenset) else value)]
    value = value.tolist() if hasattr(value, "tolist") else value
    return str(value) if isinstance(value, Path) else value


def from_plain(kind: Any, data: Any) -> Any:
    """The value of a type that `to_plain` told."""
    if get_origin(kind) is UnionType and isinstance(data, list):
        kind = next((part for part in get_args(kind) if get_origin(part) is tuple), kind)
    parts = get_args(kind)
    if hasattr(kind, "from_json"):
        return kind.from_json(data)
    if _has_fields(kind):
        return _made(kind, data)
    if get_origin(kind) is frozenset:
        return frozenset(data)
    if get_origin(kind) is tuple:
        return tuple(map(from_plain, repeat(parts[0]) if parts[1:] == (...,) else parts, data))
    if isinstance(data, Mapping):  # one of several dataclasses: that which has these fields
        kind = next((part for part in parts if _has_fields(part) and data.keys() <= _kinds(part).keys()), None)
        return data if kind is None else from_plain(kind, data)
    return Path(data) if kind is Path else data


@cache
def _has_fields(kind: Any) -> bool:
    return hasattr(kind, "_fields") or is_dataclass(kind)


def _told(value: Any) -> dict[str, Any]:
    told: dict[str, Any] = {}
    for key, get in _entries(cast(Any, type(value))):
        item = to_plain(get(value))
        told |= {key: item} if key else item or {}
    return told


@cache
def _entries(target: Any) -> list[tuple[str, Callable[[Any], Any]]]:
    """What a type tells: each key, empty where the keys are those of what is told, and what looks the value up."""
    found: list[tuple[str, Callable[[Any], Any]]] = []
    for entry in getattr(target, "TELLS", None) or _kinds(target):
        key, _, name = entry.rpartition("=")
        found.append(("" if name.startswith("*") else key or name, attrgetter(name.removeprefix("*"))))
    return found


def _made(kind: Any, data: Any) -> Any:
    return kind(**{name: from_plain(part, data[name]) for name, part in _kinds(kind).items() if name in data})


@cache
def _kinds(target: Any) -> dict[str, Any]:
    """The types of a dataclass's fields, or of a named tuple's, by name."""
    hints = get_type_hints(target)
    return {name: hints[name] for name in getattr(target, "_fields", None) or [it.name for it in fields(target)]}
