"""Typed parameters: the fields of the dataclass that a name stands for."""

import dataclasses
import typing
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pydantic

from harness.errors import UsageError


@dataclass(frozen=True)
class Parameter:
    """One parameter as ``harness describe`` shows it."""

    name: str
    type: str
    default: Any
    description: str


def build(target: Any, given: Mapping[str, Any], noun: str) -> Any:
    """An instance of the dataclass `target` with the parameters `given`, converted and checked.

    Texts are converted to the type of their field; a tuple's items are joined by 'x' (``64x64``).

    Raises:
        UsageError: A parameter is unknown, of the wrong type or out of range; names what there is.
    """
    names = [parameter.name for parameter in parameters_of(target)]
    for key in given:
        if key not in names:
            raise UsageError(f"{noun.capitalize()} has no parameter '{key}'. There is: {', '.join(names) or 'none'}.")
    hints = typing.get_type_hints(target)
    values = {key: _split_tuple(hints[key], value) for key, value in given.items()}
    try:
        return pydantic.TypeAdapter(target).validate_python(values)
    except pydantic.ValidationError as error:
        raise UsageError(f"{noun.capitalize()}: {_first_problem(error)}") from None


def resolved(target: Any, given: Mapping[str, Any], noun: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """All parameters with their values, and of these the ones that differ from their defaults."""
    values = values_of(build(target, given, noun))
    missing = object()
    defaults = {parameter.name: parameter.default for parameter in parameters_of(target)}
    changed = {key: value for key, value in values.items() if value != defaults.get(key, missing)}
    return values, changed


def values_of(instance: Any) -> dict[str, Any]:
    """The parameters of a built thing, in the order of its fields."""
    return {field.name: getattr(instance, field.name) for field in dataclasses.fields(instance) if field.init}


def parameters_of(target: Any) -> list[Parameter]:
    """The parameters that a registered dataclass takes; an empty list for any other target."""
    if not dataclasses.is_dataclass(target):
        return []
    hints = typing.get_type_hints(target)
    extras = typing.get_type_hints(target, include_extras=True)
    return [
        Parameter(field.name, _type_name(hints[field.name]), _default_of(field), _description_of(extras[field.name]))
        for field in dataclasses.fields(target)
        if field.init
    ]


def _split_tuple(hint: Any, value: Any) -> Any:
    is_tuple = typing.get_origin(hint) is tuple
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
    problem = error.errors()[0]
    where = ".".join(str(part) for part in problem["loc"])
    message = problem["msg"].removeprefix("Value error, ")
    return f"{where}={problem['input']!r}: {message}" if where else message
