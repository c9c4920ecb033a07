"""Who registered what: entry points in, specs out. Nothing heavy is imported before a spec is loaded."""

import os
import re
import sys
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.metadata import Distribution, EntryPoint, entry_points
from types import ModuleType
from typing import TYPE_CHECKING, NamedTuple, Self

import pluggy

from harness.errors import UsageError, one_line
from harness.hookspecs import KINDS, NOUNS, PROJECT, Hooks
from harness.registry.choice import Plugin, Registry
from harness.registry.given import Given, PluginClass, PluginFile
from harness.registry.plugin_module import class_of_file, import_file
from harness.registry.spec import OURS, Spec, canonical, did_you_mean, fault_of, hooks_of, module_of

if TYPE_CHECKING:
    from harness.registry.step_functions import StepFunction


_NAME = re.compile(r"[a-z0-9][a-z0-9_-]*")
_TARGET = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*")


def load_registry(
    found: Iterable[EntryPoint] | None = None,
    given: Sequence[Given] = (),
    on_load: Callable[[EntryPoint | Given], None] = lambda plugin: None,
) -> Registry:
    """Load the plugins one by one; a broken one is recorded and breaks nothing else.

    Args:
        found: Entry points to load; those of the installed distributions if None. The environment variable
            HARNESS_PLUGINS, where it is set, says which of them; see `Wanted`.
        given: What was given by hand, beside those.
        on_load: Called with each plugin before it is imported. If an import ends the process or never returns, the
            plugin of the last call is the one.

    Raises:
        UsageError: What was given by hand cannot be loaded, registers nothing, or claims a name that is taken.
    """
    registry = Registry(given=tuple(given))
    manager = pluggy.PluginManager(PROJECT)
    manager.add_hookspecs(Hooks)
    wanted = Wanted.from_environment()
    candidates = installed(PROJECT) if found is None else found
    for point in sorted(candidates, key=lambda point: (point.name, point.value)):
        origin = _origin_of(point.dist) if point.dist else Origin(point.module, "")
        reason = wanted.why_off(point.name, origin.distribution)
        if reason:
            registry.plugins.append(Plugin(point.name, *origin, point.module, "off", reason))
            continue
        on_load(point)
        _load_plugin(point, origin, manager, registry)
    registry.notes += wanted.unknown([(plugin.name, plugin.distribution) for plugin in registry.plugins])
    for one in given:
        on_load(one)
        _load_given(one, manager, registry)
    return registry


class Origin(NamedTuple):
    """Where a plugin comes from."""

    distribution: str
    version: str


@lru_cache(maxsize=64)  # to ask a distribution for anything reads its metadata, each time
def _origin_of(distribution: Distribution) -> Origin:
    return Origin(distribution.name, distribution.version)


def _load_plugin(point: EntryPoint, origin: Origin, manager: pluggy.PluginManager, registry: Registry) -> None:
    status, registered = "ok", tuple[str, ...]()
    try:
        module = point.load()
        reason = "another entry point names the same module" if manager.is_registered(module) else fault_of(module)
        if reason:
            status = "incompatible"
        else:
            manager.register(module)
            registered = _add(_collect_specs(point.name, origin, module, manager), registry)
    except (Exception, SystemExit) as error:  # whatever a stranger's module does at import, the others go on
        status, reason = "broken", one_line(error)
    registry.plugins.append(Plugin(point.name, *origin, point.module, status, reason, registered))


def _load_given(given: Given, manager: pluggy.PluginManager, registry: Registry) -> None:
    """One that was given by hand; what is wrong with it is an error, for it was asked for by its name."""
    if isinstance(given, PluginClass):
        module = given.spec.distribution
        registry.plugins.append(Plugin(given.name, module, "", module, "ok", "", _add([given.spec], registry)))
        return
    try:
        _load_file(given, manager, registry)
    except UsageError as error:
        if not given.optional:
            raise
        registry.plugins.append(Plugin(given.name, given.name, given.digest[:8], given.module, "broken", str(error)))


def _load_file(file: PluginFile, manager: pluggy.PluginManager, registry: Registry) -> None:
    # here, since it takes what pays and measures steps, which no command needs that is given no file
    from harness.registry.step_functions import for_environments, functions_of_file, own_functions

    module = import_file(file)
    taken = {name for kind, name in registry.specs if kind == "rewards"}
    functions = [] if hooks_of(module) else for_environments(functions_of_file(file, module), taken)
    for function in functions:
        _require_free_function(function, registry)
    specs = [it.spec for it in functions if it.spec] if functions else _specs_of_file(file, module, manager)
    for spec in specs:
        _require_free(spec, file, registry)
    registry.functions += functions
    told = (*_add(specs, registry), *(f"{it.noun} {it.name} of environments" for it in functions if not it.spec))
    own = own_functions(file, module) if functions else ()
    registry.plugins.append(Plugin(file.name, file.name, file.digest[:8], file.module, "ok", "", told, own))


def _specs_of_file(file: PluginFile, module: ModuleType, manager: pluggy.PluginManager) -> list[Spec]:
    if not hooks_of(module):
        return [replace(class_of_file(file, module), version=file.digest[:8])]
    manager.register(module)
    try:
        specs = _collect_specs(file.name, Origin(file.name, file.digest[:8]), module, manager)
    except (Exception, SystemExit) as error:
        raise UsageError(f"Plugin file '{file.path}': its hooks raise {one_line(error)}") from None
    if not specs:
        raise UsageError(f"Plugin file '{file.path}' registers nothing")
    return specs


def _require_free_function(function: "StepFunction", registry: Registry) -> None:
    path = function.file.path
    if not _NAME.fullmatch(function.name):
        told = f"the name '{function.name}' must be lower-case letters, digits, '-' and '_'"
        raise UsageError(f"Plugin file '{path}': {told}. Rename it")
    other = registry.functions_of(function.noun).get(function.name)
    if other is not None:
        raise UsageError(
            f"Plugin file '{path}': the {function.noun} '{function.name}' stands in '{other.file.path}' too"
        )


def _require_free(spec: Spec, file: PluginFile, registry: Registry) -> None:
    if not _NAME.fullmatch(spec.name):
        told = f"its name '{spec.name}' must be lower-case letters, digits, '-' and '_'"
        raise UsageError(f"Plugin file '{file.path}': {told}. Rename the file")
    for name in spec.claims:
        claimed = registry.specs.get((spec.kind, name))
        if not claimed:
            continue
        what = f"the name of {NOUNS[spec.kind]} '{name}' is taken by package {claimed[0].package}"
        remedy = "the function" if file.measures else "the file, or what its hook registers"
        raise UsageError(f"Plugin file '{file.path}': {what}. Rename {remedy}")


def _add(specs: list[Spec], registry: Registry) -> tuple[str, ...]:
    """Take specs in; returns what to say of them."""
    for spec in specs:
        for name in spec.claims:
            registry.specs.setdefault((spec.kind, name), []).append(spec)
    return tuple(f"{NOUNS[spec.kind]} {spec.name}" for spec in specs)


def _collect_specs(plugin: str, origin: Origin, module: ModuleType, manager: pluggy.PluginManager) -> list[Spec]:
    specs: list[Spec] = []
    others = [plugin for plugin in manager.get_plugins() if plugin is not module]
    for kind in KINDS:
        caller = manager.subset_hook_caller(f"register_{kind}", others)
        caller(register=_register_into(specs, kind, plugin, origin))
    return specs


def _register_into(specs: list[Spec], kind: str, plugin: str, origin: Origin) -> Callable[..., None]:
    def register(
        name: str,
        target: str,
        *,
        summary: str,
        requires: Iterable[str] = (),
        extra: str | None = None,
        heading: str = "",
        short: str = "",
    ) -> None:
        for given in (name, short) if short else (name,):
            if not _NAME.fullmatch(given):
                raise ValueError(f"register_{kind}: name {given!r} must be lower-case letters, digits, '-' and '_'")
        if not _TARGET.fullmatch(target):
            raise ValueError(f"register_{kind}: target {target!r} of '{name}' must be 'module:attribute'")
        if isinstance(requires, str):
            raise ValueError(f"register_{kind}: requires of '{name}' must be a list of modules, not a string")
        requires = tuple(requires)
        for need in requires:
            module_of(need)  # raises an error if it is none
        specs.append(Spec(kind, name, target, summary, requires, extra, plugin, *origin, heading, short))

    return register


def installed(group: str) -> tuple[EntryPoint, ...]:
    """The entry points of a group, of all installed distributions.

    To look for them opens a file of every distribution. It is done again where Python searches elsewhere, and where
    something was installed or removed since, which changes the folder.
    """
    return _entry_points(group, tuple((folder, _changed(folder)) for folder in map(os.path.abspath, sys.path)))


@lru_cache(maxsize=4)
def _entry_points(group: str, _: tuple[tuple[str, int], ...]) -> tuple[EntryPoint, ...]:
    return tuple(entry_points(group=group))


def _changed(folder: str) -> int:
    """When a folder's list of names changed last, [ns]; 0 of what is none."""
    try:
        return os.stat(folder).st_mtime_ns
    except OSError:
        return 0


VARIABLE = "HARNESS_PLUGINS"


@dataclass(frozen=True)
class Wanted:
    """What the variable says, a list with commas: names of plugins to load, and ``-name`` for plugins to leave out.

    A name is that of an entry point, ``clash``, that of a distribution, ``clash-algo``, or both, ``clash-algo/clash``.
    Where no name without a minus stands, everything else loads; where one stands, the named alone. Built-in plugins
    load unless one is left out by its name.

    Attributes:
        named: To load; None where everything is.
        left_out: Not to load.
    """

    named: frozenset[str] | None = None
    left_out: frozenset[str] = frozenset()

    @classmethod
    def from_environment(cls) -> Self:
        """What the variable of this process says; everything is wanted where it is not set."""
        value = os.environ.get(VARIABLE)
        if value is None:
            return cls()
        words = [word.strip() for word in value.split(",") if word.strip()]
        left_out = frozenset(word[1:].strip() for word in words if word.startswith("-"))
        named = frozenset(word for word in words if not word.startswith("-"))
        return cls(named if named or not left_out else None, left_out)

    def why_off(self, plugin: str, distribution: str) -> str:
        """Why a plugin is not loaded; empty if it is."""
        names = _names_of(plugin, distribution)
        if names & self.left_out:
            return f"left out by {VARIABLE}"
        if self.named is None or distribution == OURS or names & self.named:
            return ""
        return f"not named in {VARIABLE}"

    def unknown(self, plugins: Collection[tuple[str, str]]) -> list[str]:
        """A line for each name in the variable that is no plugin's.

        Args:
            plugins: Entry point and distribution of each plugin.
        """
        known = {name for plugin in plugins for name in _names_of(*plugin)}
        asked = sorted((self.named or frozenset()) | self.left_out)
        return [
            f"{VARIABLE} names '{it}', which is no plugin.{did_you_mean(it, known)}" for it in asked if it not in known
        ]


def _names_of(plugin: str, distribution: str) -> frozenset[str]:
    spellings = {distribution, canonical(distribution)}
    return frozenset({plugin, *spellings, *(f"{spelling}/{plugin}" for spelling in spellings)})
