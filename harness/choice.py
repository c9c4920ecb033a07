"""What a user picks: a name with parameters, ``arp:k1=1,k2=1.5``."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from harness.errors import UsageError
from harness.parameters import build, resolved
from harness.plugins import Registry

SYNTAX = "write name or name:key=value,key=value"


@dataclass(frozen=True)
class Choice:
    """A registered name with all its parameters, those left at their defaults included.

    Attributes:
        name: The registered name.
        params: Every parameter with its value, in the order of the target's fields; JSON-able.
        label: What to call it: the name, and the parameters that differ from their defaults.
    """

    name: str
    params: tuple[tuple[str, Any], ...] = ()
    label: str = ""

    def to_json(self) -> dict[str, Any]:
        """Plain data; `from_json` gives the same choice back."""
        return {"name": self.name, "label": self.label, "params": {key: _plain(value) for key, value in self.params}}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> "Choice":
        """The choice that `to_json` wrote."""
        params = tuple((key, _frozen(value)) for key, value in data["params"].items())
        return cls(data["name"], params, data["label"])

    def build(self, registry: Registry, kind: str) -> Any:
        """The chosen thing: the registered target, with these parameters."""
        return build(registry.get(kind, self.name).load(), dict(self.params), f"{kind[:-1]} '{self.name}'")


def choose(registry: Registry, kind: str, given: str | Mapping[str, Any]) -> Choice:
    """Resolve what a user gave: ``"arp:k2=2"`` or ``{"name": "arp", "k2": 2}``.

    Raises:
        UsageError: Unknown name, malformed text, unknown parameter, wrong type or value out of range.
    """
    name, params = parse(given) if isinstance(given, str) else _name_and_params(given)
    noun = f"{kind[:-1]} '{name}'"
    target = registry.get(kind, name).load()
    values, changed = resolved(target, params, noun)
    text = ",".join(f"{key}={_text(value)}" for key, value in changed.items())
    frozen = tuple((key, _frozen(value)) for key, value in values.items())
    return Choice(name, frozen, f"{name}:{text}" if text else name)


def split_list(given: str | Iterable[str]) -> list[str]:
    """Split ``a,b:x=1,y=2,c`` into ``a``, ``b:x=1,y=2`` and ``c``.

    A comma starts a new name unless ``key=value`` follows, which belongs to the name before it.
    """
    texts = [given] if isinstance(given, str) else list(given)
    names: list[str] = []
    for text in texts:
        for index, part in enumerate(text.split(",")):
            belongs = index > 0 and "=" in part and ":" not in part.split("=")[0]
            if belongs and ":" in names[-1]:
                names[-1] += "," + part
            else:
                names.append(part.strip())
    return names


def parse(text: str) -> tuple[str, dict[str, str]]:
    """Split ``name:key=value,key=value`` into the name and its parameters, still text.

    Raises:
        UsageError: The text is malformed.
    """
    name, colon, rest = text.partition(":")
    if not name or "=" in name or (colon and not rest):
        raise UsageError(f"'{text}' is malformed: {SYNTAX}")
    params: dict[str, str] = {}
    for part in rest.split(",") if rest else []:
        key, equals, value = part.partition("=")
        if not (key.strip() and equals and value.strip()):
            raise UsageError(f"'{part}' in '{text}' is malformed: {SYNTAX}")
        if key.strip() in params:
            raise UsageError(f"'{key.strip()}' is given twice in '{text}'")
        params[key.strip()] = value.strip()
    return name.strip(), params


def _name_and_params(given: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    params = dict(given)
    name = params.pop("name", None)
    if not isinstance(name, str):
        raise UsageError(f"{dict(given)} has no name: write {{name = '...', key = value}}")
    return name, params


def _plain(value: Any) -> Any:
    return [_plain(item) for item in value] if isinstance(value, tuple) else value


def _frozen(value: Any) -> Any:
    return tuple(_frozen(item) for item in value) if isinstance(value, list | tuple) else value


def _text(value: Any) -> str:
    if isinstance(value, list | tuple):
        return "x".join(_text(item) for item in value)
    if isinstance(value, float) and float(f"{value:g}") == value:
        return f"{value:g}"
    return str(value)
