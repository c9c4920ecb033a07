"""Typed parameters: the fields of the dataclass that a name stands for."""

import dataclasses
import math
import typing
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any

import pydantic

from harness.errors import PluginError, UsageError, sentence
from harness.registry.names import did_you_mean
from harness.registry.registry import Registry
from harness.text import shortened

SHOWN = 100
"""Characters of a value that is refused."""


@dataclass(frozen=True)
class Parameter:
    """One parameter as ``harness describe`` shows it. One without a default has to be given."""

    name: str
    type: str
    default: Any
    description: str
    has_default: bool = True


def build(target: Any, given: Mapping[str, Any], noun: str, registry: Registry | None = None) -> Any:
    """An instance of the dataclass `target` with the parameters `given`, converted and checked.

    Args:
        target: What a plugin registered.
        given: By name. Texts are converted to the type of their field; a tuple's items are joined by 'x' (``64x64``).
        noun: What to call it, ``reward 'arp'``.
        registry: For a target that builds on another registered one: pydantic's validators find it as
            ``info.context["registry"]``.

    Raises:
        UsageError: A parameter is unknown, of the wrong type or out of range; names what there is.
        PluginError: The target is no dataclass, or the types of its fields cannot be checked.
    """
    adapter = _adapter(target, noun)
    names = [parameter.name for parameter in parameters_of(target)]
    for key in given:
        if key not in names:
            there = f"There is: {', '.join(names) or 'none'}.{did_you_mean(key, names)}"
            raise UsageError(f"{sentence(noun)} has no parameter '{key}'. {there}")
    hints = _hints(target)
    values = {key: _split_tuple(hints[key], value) for key, value in given.items()}
    try:
        built = adapter.validate_python(values, context={"registry": registry})
    except pydantic.ValidationError as error:
        raise UsageError(f"{sentence(noun)}: {_first_problem(error)}") from None
    for key, value in values_of(built).items():
        if not _is_finite(value):
            raise UsageError(f"{sentence(noun)}: {key}={value!r}: Input should be a finite number")
    return built


def resolved(target: Any, built: Any, noun: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """All parameters of a built thing with their values, and of these the ones that differ from their defaults.

    Where a parameter stands for several, such as a preset, the target's method ``defaults_with(values)`` gives the
    defaults that it brings.

    Args:
        target: What a plugin registered.
        built: What `build` made of it.
        noun: What to call it, ``reward 'arp'``.

    Raises:
        UsageError: A default does not fit its field.
    """
    # Only what is given was converted to the type of its field: a default of 1 is to be 1.0 where that is a float.
    values = values_of(build(_fields_alone(target), values_of(built), noun))
    missing = object()
    defaults = {parameter.name: parameter.default for parameter in parameters_of(target)}
    if hasattr(target, "defaults_with"):
        defaults.update(target.defaults_with(values))
    changed = {key: value for key, value in values.items() if value != defaults.get(key, missing)}
    return values, changed


def values_of(instance: Any) -> dict[str, Any]:
    """The parameters of a built thing, in the order of its fields."""
    return {field.name: getattr(instance, field.name) for field in dataclasses.fields(instance) if field.init}


def parameters_of(target: Any) -> list[Parameter]:
    """The parameters that a registered dataclass takes; an empty list for any other target."""
    if not dataclasses.is_dataclass(target):
        return []
    known = typing.cast(Any, target)  # mypy takes a dataclass for not hashable
    hints, extras = _hints(known), _hints(known, include_extras=True)
    return [
        Parameter(
            field.name,
            _type_name(hints[field.name]),
            _default_of(field),
            _description_of(extras[field.name]),
            field.default is not dataclasses.MISSING or field.default_factory is not dataclasses.MISSING,
        )
        for field in dataclasses.fields(target)
        if field.init
    ]


def _adapter(target: Any, noun: str) -> "pydantic.TypeAdapter[Any]":
    if not dataclasses.is_dataclass(target):
        raise PluginError(f"{sentence(noun)}: its target {target!r} is no dataclass")
    try:
        return _type_adapter(typing.cast(Any, target))  # mypy takes a dataclass for not hashable
    except (pydantic.errors.PydanticUserError, NameError) as error:
        reason = str(error).splitlines()[0]
        raise PluginError(f"{sentence(noun)}: the types of its parameters cannot be checked: {reason}") from error


@cache
def _hints(target: Any, include_extras: bool = False) -> Mapping[str, Any]:
    """The types of a dataclass's fields, by their names."""
    return MappingProxyType(typing.get_type_hints(target, include_extras=include_extras))


@cache  # a run builds the same few classes hundreds of times
def _type_adapter(target: Any) -> "pydantic.TypeAdapter[Any]":
    _hints(target)
    return pydantic.TypeAdapter(target)


@cache
def _fields_alone(target: Any) -> Any:
    """A dataclass of the same parameters that does nothing when it is built, and takes every one of them."""
    hints = _hints(target, include_extras=True)
    fields = [(field.name, hints[field.name]) for field in dataclasses.fields(target) if field.init]
    settings = {"__pydantic_config__": getattr(target, "__pydantic_config__", {})}
    return dataclasses.make_dataclass("Fields", fields, namespace=settings)


def _is_finite(value: Any) -> bool:
    if isinstance(value, tuple | list):
        return all(_is_finite(item) for item in value)
    return not isinstance(value, float) or math.isfinite(value)


def _split_tuple(hint: Any, value: Any) -> Any:
    kinds = [hint, *typing.get_args(hint)]  # of an optional tuple, the tuple is one of the arguments
    is_tuple = any(typing.get_origin(kind) is tuple for kind in kinds)
    return value.split("x") if is_tuple and isinstance(value, str) else value


def _default_of(field: "dataclasses.Field[Any]") -> Any:
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return None if field.default is dataclasses.MISSING else field.default


def _description_of(hint: Any) -> str:
    infos = [item for item in typing.get_args(hint)[1:] if hasattr(item, "description")]
    return next((info.description for info in infos if info.description), "")


def _type_name(hint: Any) -> str:
    return hint.__name__ if isinstance(hint, type) and not typing.get_args(hint) else str(hint).replace("typing.", "")


def _first_problem(error: pydantic.ValidationError) -> str:
    """The problem that lies deepest: of the alternatives that a field allows, the one that was meant.

    What has the right type and the wrong value was meant rather than what has another type.
    """
    problem = max(error.errors(), key=lambda problem: (len(problem["loc"]), not problem["type"].endswith("_type")))
    field, *inner = problem["loc"] or ("",)
    where = ".".join([str(field), *(str(part) for part in inner if isinstance(part, int))])
    message = problem["msg"].removeprefix("Value error, ")
    if problem["type"] == "missing":
        return f"{where} has to be given"
    return f"{where}={shortened(repr(problem['input']), SHOWN)}: {message}" if where else message
