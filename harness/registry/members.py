"""What a thing of each kind must have, how it is called, and the parameters that it takes."""

import dataclasses
import inspect
import typing
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from harness.errors import PluginError, UsageError, sentence
from harness.hookspecs import NOUNS
from harness.registry.spec import Spec, did_you_mean
from harness.text import shortened

if TYPE_CHECKING:
    import pydantic

MEMBERS: Mapping[str, Mapping[str, int | None]] = MappingProxyType(
    {
        "simulators": {"open": 3},
        "algorithms": {"action_spaces": None, "num_envs": None, "train": 4},
        "rewards": {"initial_carry": 1, "__call__": 2},
        "metrics": {"unit": None, "better": None, "__call__": 1},
        "tasks": {
            **dict.fromkeys(
                ("robot", "epsilon", "ends_at_target", "horizon", "control_period", "decision_period", "ground_reward"),
            ),
            **dict.fromkeys(("step_reward", "action", "speed", "acceleration")),
            "target_rewards": 2,
            "motion": 1,
            "observation": 1,
            "check": 1,
            "draw_start": 2,
            "draw_targets": 3,
            "start_in_words": 1,
            "target_in_words": 1,
            "target_reward_in_words": 0,
        },
        "environments": {"make": 0, "rewards": 1, "behaviour": 1},
        "executors": {"run": 3},
        "trackers": {"why_not": 0, "begin": 1},
        "logs": {"recognises": 2, "read": 1, "write_example": 1},
        "descriptions": {"recognises": 2, "read": 3, "write_example": 1},
        "screens": {"screen": 2},
        "sections": {"what": None, "ending": 1, "show": 1},
    }
)
"""What a target of each kind must have: of a method how many arguments it is called with, of a value None."""


def require_members(spec: Spec, built: Any) -> None:
    """See that a built thing has every member that its kind asks for.

    Raises:
        PluginError: It lacks one; says whose plugin it is, and what a thing of its kind has.
    """
    missing = missing_members(spec.kind, built)
    if missing:
        raise PluginError(f"{spec.title} {missing}")


def missing_members(kind: str, thing: Any) -> str:
    """What a thing of one kind, or its class, lacks: ``has no train; an algorithm has ...``. Empty if it lacks nothing.

    A field of a dataclass counts as there.
    """
    members = MEMBERS.get(kind, {})
    fields = {field.name for field in dataclasses.fields(thing)} if dataclasses.is_dataclass(thing) else set()
    lacking = [name for name in members if name not in fields and not _has(thing, name)]
    if lacking:
        noun = f"{'an' if NOUNS[kind][0] in 'aeiou' else 'a'} {NOUNS[kind]}"
        return f"has no {', '.join(lacking)}; {noun} has {', '.join(members)}"
    for name, count in members.items():
        if count is not None and not _takes(getattr(thing, name), count + inspect.isclass(thing)):
            arguments = f"{count} argument{'s' * (count != 1)}"
            return f"cannot be called as it has to be: {name} takes {arguments} beside self"
    return ""


def sample_of(target: Any) -> Any:
    """One with default parameters, which may have members that the class has not; the class itself if that fails."""
    try:
        return target()
    except (Exception, SystemExit):
        return target


def _has(thing: Any, name: str) -> bool:
    """Whether a class or an object of it has a member; every class can be called, which says nothing of its objects."""
    if name == "__call__":
        kind = thing if inspect.isclass(thing) else type(thing)
        return any(name in vars(base) for base in kind.__mro__)
    return hasattr(thing, name)


def _takes(method: Any, count: int) -> bool:
    """Whether it can be called with so many arguments by position."""
    try:
        inspect.signature(method).bind(*[None] * count)
    except TypeError:
        return False
    except ValueError:  # compiled, without a signature
        return True
    return True


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


def build(target: Any, given: Mapping[str, Any], noun: str, registry: object = None) -> Any:
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
    import pydantic  # a command that builds nothing does not load it, nor numpy

    from harness.reward.reward import is_finite

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
        if not is_finite(value):
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
            next(filter(None, (getattr(it, "description", "") for it in typing.get_args(extras[field.name])[1:])), ""),
            field.default is not dataclasses.MISSING or field.default_factory is not dataclasses.MISSING,
        )
        for field in dataclasses.fields(target)
        if field.init
    ]


def _adapter(target: Any, noun: str) -> "pydantic.TypeAdapter[Any]":
    from pydantic.errors import PydanticUserError

    if not dataclasses.is_dataclass(target):
        raise PluginError(f"{sentence(noun)}: its target {target!r} is no dataclass")
    try:
        return _type_adapter(typing.cast(Any, target))  # mypy takes a dataclass for not hashable
    except (PydanticUserError, NameError) as error:
        reason = str(error).splitlines()[0]
        raise PluginError(f"{sentence(noun)}: the types of its parameters cannot be checked: {reason}") from error


@cache
def _hints(target: Any, include_extras: bool = False) -> Mapping[str, Any]:
    """The types of a dataclass's fields, by their names."""
    return MappingProxyType(typing.get_type_hints(target, include_extras=include_extras))


@cache  # a run builds the same few classes hundreds of times
def _type_adapter(target: Any) -> "pydantic.TypeAdapter[Any]":
    from pydantic import TypeAdapter

    _hints(target)
    return TypeAdapter(target)


@cache
def _fields_alone(target: Any) -> Any:
    """A dataclass of the same parameters that does nothing when it is built, and takes every one of them."""
    hints = _hints(target, include_extras=True)
    fields = [(field.name, hints[field.name]) for field in dataclasses.fields(target) if field.init]
    settings = {"__pydantic_config__": getattr(target, "__pydantic_config__", {})}
    return dataclasses.make_dataclass("Fields", fields, namespace=settings)


def _split_tuple(hint: Any, value: Any) -> Any:
    kinds = [hint, *typing.get_args(hint)]  # of an optional tuple, the tuple is one of the arguments
    is_tuple = any(typing.get_origin(kind) is tuple for kind in kinds)
    return value.split("x") if is_tuple and isinstance(value, str) else value


def _default_of(field: "dataclasses.Field[Any]") -> Any:
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return None if field.default is dataclasses.MISSING else field.default


def _type_name(hint: Any) -> str:
    return hint.__name__ if isinstance(hint, type) and not typing.get_args(hint) else str(hint).replace("typing.", "")


def _first_problem(error: "pydantic.ValidationError") -> str:
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
