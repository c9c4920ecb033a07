"""Objects where names are expected: a reward, a simulator or an algorithm that a Python program has built."""

import dataclasses
import inspect
from collections.abc import Mapping, Sequence
from typing import Any

from harness.errors import UsageError
from harness.registry.given import Given, PluginClass, class_given
from harness.registry.members import MEMBERS, missing_members, values_of
from harness.registry.registry import load_registry

KINDS = {"sim": "simulators", "algo": "algorithms", "reward": "rewards", "baseline": "rewards", "task": "tasks"}
"""Kinds of plugins, by the arguments that take objects."""


def name_objects(arguments: Mapping[str, Any]) -> tuple[dict[str, Any], tuple[Given, ...]]:
    """Arguments of `harness.run` with a table of name and parameters for each object, and the objects' classes.

    A class that a plugin registered has the plugin's name, and is not among the classes.

    Raises:
        UsageError: An object is no dataclass's, or its class cannot be imported by a worker process.
    """
    named, found = dict(arguments), dict[PluginClass, None]()
    for key in KINDS.keys() & arguments.keys():
        value = arguments[key]
        is_list = isinstance(value, Sequence) and not isinstance(value, str)
        items = [_named(key, item, found) for item in (value if is_list else [value])]
        named[key] = items if is_list else items[0]
    return named, tuple(found)


def _named(key: str, item: Any, found: dict[PluginClass, None]) -> Any:
    if isinstance(item, str | Mapping):
        return item
    kind = KINDS[key]
    if key == "task" and not missing_members("environments", item):
        kind = "environments"
    if inspect.isclass(item) or not dataclasses.is_dataclass(item):
        told = f"{key}={item!r}: give a name, or an object of a dataclass with {', '.join(MEMBERS[kind])}"
        raise UsageError(f"{told}. A function, a lambda or a class cannot be sent to a worker")
    given = class_given(type(item), kind)
    registered = [it for it in load_registry().all_specs() if (it.kind, it.target) == (kind, given.target)]
    if registered:
        return {"name": registered[0].name, **values_of(item)}
    found[given] = None
    return {"name": given.spec.qualified, **values_of(item)}
