"""Functions in plugin files that say a number for a step: rewards, and measures of behaviour.

A plugin file without hooks and without a plugin class may have plain functions of ``step``, for an arm or for any
environment; measures that are plain functions of ``episode``, for an arm; and for environments functions of
`ARGUMENTS`, `functools.partial` ones of either, and objects that can be called so. A reward with a memory is a class
with ``reset()`` whose objects can be called so; each env gets an object of its own. Other classes, such as settings,
and other functions are the file's own, see `own_functions`. If a file has one reward, the reward has the name of the
file. If it has several, each has its own name, a class in lower case.
"""

import functools
import inspect
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from types import ModuleType
from typing import Any

from harness.errors import UsageError
from harness.eta.interval import UNBOUNDED, Bounds
from harness.eta.laws import Better
from harness.registry.given import PluginFile
from harness.registry.measure_functions import (
    HIGHER,
    LOWER,
    Said,
    is_function_of_episodes,
    is_measure_function,
    said_of,
)
from harness.registry.members import MEMBERS, missing_members
from harness.registry.plugin_module import import_file, public_classes
from harness.registry.spec import Spec
from harness.reward.forms import STEP, reward_class, takes_alone, takes_step
from harness.reward.given import ARGUMENTS, takes_arguments
from harness.reward.steps import BEFORE, ENVIRONMENT, MissingField
from harness.reward.terms import needs_of

PLUGIN_METHODS = frozenset(
    name for of in MEMBERS.values() for name, count in of.items() if count is not None and name != "__call__"
)
"""Names of methods that plugins of some kind must have."""
WHAT_ONE_TAKES = f"a reward or a measure takes ({STEP}), or in an environment {ARGUMENTS}"


@dataclass(frozen=True)
class StepFunction:
    """A reward for the steps of any environment, or a measure of behaviour in them.

    Attributes:
        name: What users type.
        attribute: Its name in the file.
        file: Where it stands.
        better: Of a measure, which values are, ``higher`` or ``lower``; empty if the file does not say it.
        bounds: Of a measure, what it can be, if the file says so.
        summary: The first line of its docstring.
        is_of_steps: Whether it takes ``step``, so that it can pay or measure an arm too.
        is_of_episodes: Whether it takes ``episode``, so that it measures an arm alone.
    """

    name: str
    attribute: str
    file: PluginFile
    better: Better = ""
    bounds: Bounds = UNBOUNDED
    summary: str = ""
    is_of_steps: bool = False
    is_of_episodes: bool = False

    @property
    def noun(self) -> str:
        """What it is."""
        return "measure" if self.file.measures else "reward"

    @property
    def told(self) -> str:
        """For people, to begin a sentence with: the file, and what it is there."""
        is_class = inspect.isclass(getattr(import_file(self.file), self.attribute))
        what = f"the class {self.attribute}" if is_class else f"{self.attribute}{ARGUMENTS}"
        return f"In {self.file.name}, {what}"

    @property
    def spec(self) -> Spec | None:
        """The reward or the metric that it is for an arm; None if it is none."""
        if not (self.is_of_steps or self.is_of_episodes):
            return None
        kind = "metrics" if self.file.measures else "rewards"
        target, origin = f"{self.file.module}:{self.attribute}", self.file.name
        return Spec(kind, self.name, target, self.summary, (), None, origin, origin, self.file.digest[:8])

    def make(self) -> Any:
        """The function; of a class a new object. It is called with a step, an episode, or `ARGUMENTS`."""
        found = getattr(import_file(self.file), self.attribute)
        return found() if inspect.isclass(found) else found


def functions_of_file(file: PluginFile, module: ModuleType) -> list[StepFunction]:
    """What a file without hooks has; empty if a public class of it is a plugin of some kind, or it has nothing.

    Raises:
        UsageError: No public function takes such arguments, or `LOWER` names something else than measures of the file.
    """
    classes = public_classes(file, module)
    if any(_is_plugin(it) for it in classes):
        return []
    objects = {
        name: it
        for name, it in vars(module).items()
        if not name.startswith("_") and not isinstance(it, type) and _is_called(file, it)
    }
    classes = [it for it in classes if _has_steps(it) and not any(type(one) is it for one in objects.values())]
    public = _public_functions(file, module)
    of_episodes = [name for name, it in public.items() if file.measures and is_function_of_episodes(it)]
    functions = [name for name, it in public.items() if _is_of_step(it)] + of_episodes
    if public and not (functions or objects or classes):
        named = ", ".join(_told(name, it) for name, it in public.items())
        raise UsageError(f"Plugin file '{file.path}': it has {named}, and {WHAT_ONE_TAKES}")
    attributes = [
        name
        for name, it in vars(module).items()
        if name in functions or name in objects or any(it is one for one in classes)
    ]
    lower = {it: it.lower() for it in attributes if vars(module)[it] in classes and it.lower() not in attributes}
    names = [lower.get(it, it) for it in attributes]
    names = [file.stem.lower()] if len(names) == 1 and not file.measures else names
    said = _said(file, module, attributes)
    return [
        StepFunction(
            name,
            it,
            file,
            said[it].better,
            said[it].bounds,
            _summary(getattr(module, it)),
            takes_alone(getattr(module, it), STEP),
            it in of_episodes,
        )
        for name, it in zip(names, attributes, strict=True)
        if name not in file.left_out
    ]


def for_environments(functions: Iterable[StepFunction], taken: Collection[str]) -> list[StepFunction]:
    """The same; a reward of a name that is taken by an arm's is one of environments alone, where it reads theirs."""
    both = [it for it in functions if it.is_of_steps and it.noun == "reward" and it.name in taken]
    return [replace(it, is_of_steps=False) if it in both and _reads_environment(it) else it for it in functions]


def _reads_environment(function: StepFunction) -> bool:
    """Whether a reward reads what a step of an arm lacks, and one of an environment has."""
    try:
        needs_of(reward_class(function.make())())
    except MissingField as missing:
        return missing.field.removeprefix(f"{BEFORE}.") in {it.name for it in ENVIRONMENT}
    except UsageError:  # it fails otherwise, which a run by it says
        return False
    return False


def own_functions(file: PluginFile, module: ModuleType) -> tuple[str, ...]:
    """Functions of a file that are no rewards and no measures, since they take something else: ``clip(x)``."""
    return tuple(
        _told(name, it)
        for name, it in _public_functions(file, module).items()
        if not (_is_of_step(it) or (file.measures and is_function_of_episodes(it)))
    )


def why_no_reward(name: str, functions: Iterable[str]) -> str:
    """Why a name is that of no reward, where it is one of `own_functions`; empty if it is none."""
    own = next((it for it in functions if it.partition("(")[0] == name), "")
    return f"{own} is no reward: {WHAT_ONE_TAKES}" if own else ""


def _public_functions(file: PluginFile, module: ModuleType) -> dict[str, Any]:
    return {
        name: it
        for name, it in vars(module).items()
        if inspect.isfunction(it) and it.__module__ == file.module and not name.startswith("_")
    }


def _is_plugin(found: type) -> bool:
    """Whether a class is meant for a plugin: it has a method that some kind of plugin must have."""
    return not _has_steps(found) and any(inspect.isfunction(getattr(found, name, None)) for name in PLUGIN_METHODS)


def _has_steps(found: type) -> bool:
    """Whether objects of a class are called for each step."""
    own = next((vars(base)["__call__"] for base in found.__mro__ if "__call__" in vars(base)), None)
    return own is not None and _is_of_step(functools.partial(own, None)) and bool(missing_members("rewards", found))


def _is_called(file: PluginFile, found: Any) -> bool:
    """Whether something is a `functools.partial`, or an object of a class of the file, that is called for a step."""
    is_of_file = type(found).__module__ == file.module and callable(found)
    return (is_of_file or isinstance(found, functools.partial)) and _is_of_step(found)


def _is_of_step(found: Any) -> bool:
    """Whether something is called with a step, or with its parts."""
    return takes_step(found) or takes_arguments(found)


def _told(name: str, function: Any) -> str:
    return f"{name}{inspect.signature(function)}"


def _summary(found: Any) -> str:
    return next(iter(inspect.cleandoc(getattr(found, "__doc__", None) or "").splitlines()), "")


def _said(file: PluginFile, module: ModuleType, names: Sequence[str]) -> dict[str, Said]:
    """What a file says of its measures."""
    is_of_arms = file.measures and any(is_measure_function(getattr(module, name)) for name in names)
    try:
        said = said_of(module, names, all_of_it=is_of_arms)
    except UsageError as error:
        raise UsageError(f"Plugin file '{file.path}': {error}") from None
    if not file.measures and any(it.better for it in said.values()):
        raise UsageError(
            f"Plugin file '{file.path}': {LOWER} and {HIGHER} go with measures, and these functions are rewards"
        )
    return said
