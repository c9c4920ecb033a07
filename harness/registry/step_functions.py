"""Functions in plugin files that say a number for a step of an environment: rewards, and measures of behaviour.

A plugin file without hooks and without a plugin class may have plain functions of `ARGUMENTS`. A reward with a memory
is a class with ``reset()`` whose objects can be called so; each env gets an object of its own. If a file has one
reward, the reward has the name of the file. If it has several, each has its own name.
"""

import inspect
from collections.abc import Iterable
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from harness.errors import UsageError
from harness.registry.given import PluginFile
from harness.registry.members import missing_members
from harness.registry.plugin_module import import_file, public_classes

ARGUMENTS = "(observation, action, next_observation, info)"
LOWER = "lower_is_better"
"""The name in a file of measures under which it lists those of which less is better."""


@dataclass(frozen=True)
class StepFunction:
    """A reward for the steps of any environment, or a measure of behaviour in them.

    Attributes:
        name: What users type.
        attribute: Its name in the file.
        file: Where it stands.
        lower_is_better: Of a measure, whether less is better.
    """

    name: str
    attribute: str
    file: PluginFile
    lower_is_better: bool = False

    @property
    def noun(self) -> str:
        """What it is."""
        return "measure" if self.file.measures else "reward"

    def make(self) -> Any:
        """The function; of a class a new object. Both can be called with `ARGUMENTS`."""
        found = getattr(import_file(self.file), self.attribute)
        return found() if inspect.isclass(found) else found


def functions_of_file(file: PluginFile, module: ModuleType) -> list[StepFunction]:
    """What a file without hooks has; empty if its one public class is a plugin of some kind, or it has nothing.

    Raises:
        UsageError: A public function takes other arguments, or `LOWER` names something else than measures of the file.
    """
    classes = public_classes(file, module)
    if any(not _has_steps(it) for it in classes):
        return []
    functions = [
        name
        for name, it in vars(module).items()
        if inspect.isfunction(it) and it.__module__ == file.module and not name.startswith("_")
    ]
    for name in functions:
        _require_arguments(file, name, getattr(module, name))
    attributes = [name for name in vars(module) if name in functions or getattr(module, name) in classes]
    names = [file.stem.lower()] if len(attributes) == 1 and not file.measures else attributes
    lower = _lower(file, module, attributes)
    return [
        StepFunction(name, it, file, it in lower)
        for name, it in zip(names, attributes, strict=True)
        if name not in file.left_out
    ]


def _has_steps(found: type) -> bool:
    """Whether objects of a class are called for each step, and are told when an episode starts."""
    is_called = "__call__" in vars(found) and _takes(found.__call__, 5)
    return is_called and callable(getattr(found, "reset", None)) and bool(missing_members("rewards", found))


def _takes(function: Any, count: int) -> bool:
    try:
        inspect.signature(function).bind(*[None] * count)
    except TypeError:
        return False
    return True


def _require_arguments(file: PluginFile, name: str, function: Any) -> None:
    if not _takes(function, 4):
        raise UsageError(
            f"Plugin file '{file.path}': {name} takes {inspect.signature(function)}, and a reward or a measure takes "
            f"{ARGUMENTS}. Begin the names of other functions with _"
        )


def _lower(file: PluginFile, module: ModuleType, known: Iterable[str]) -> set[str]:
    """The measures of which less is better."""
    given = getattr(module, LOWER, ())
    names = {given} if isinstance(given, str) else {*given}
    for name in names.difference(known):
        raise UsageError(f"Plugin file '{file.path}': {LOWER} names {name!r}, which is none of {', '.join(known)}")
    if names and not file.measures:
        raise UsageError(f"Plugin file '{file.path}': {LOWER} goes with measures, and these functions are rewards")
    return names
