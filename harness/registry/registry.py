"""Who registered what: entry points in, specs out. Nothing heavy is imported before a spec is loaded."""

import difflib
import importlib
import importlib.util
import os
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from importlib.metadata import EntryPoint, entry_points
from types import ModuleType
from typing import Any, NamedTuple

import pluggy

from harness.errors import PluginError, UsageError, one_line, sentence
from harness.hookspecs import KINDS, NOUNS, PROJECT, Hooks

API_VERSION = 1
"""Version of the interfaces. A plugin may state the one it was written for as ``harness_api = 1``."""

_NAME = re.compile(r"[a-z0-9][a-z0-9_-]*")
_TARGET = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*")


@dataclass(frozen=True)
class Spec:
    """A name that users type and the object behind it, not yet imported."""

    kind: str
    name: str
    target: str
    summary: str
    requires: tuple[str, ...]
    extra: str | None
    plugin: str
    distribution: str

    @property
    def missing(self) -> tuple[str, ...]:
        """The required modules that are not installed."""
        return tuple(module for module in self.requires if not _is_installed(module))

    @property
    def remedy(self) -> str:
        """What to type to get what is missing."""
        return (
            f"pip install '{self.distribution}[{self.extra}]'"
            if self.extra
            else "pip install " + " ".join(self.missing)
        )

    def load(self) -> Any:
        """Import the target.

        Raises:
            UsageError: A required library is not installed.
            PluginError: The target cannot be imported or does not exist.
        """
        if self.missing:
            raise UsageError(
                f"{sentence(NOUNS[self.kind])} '{self.name}' needs {', '.join(self.missing)}: {self.remedy}"
            )
        module, attribute = self.target.split(":")
        try:
            return getattr(importlib.import_module(module), attribute)
        except (Exception, SystemExit) as error:
            raise PluginError(
                f"Plugin '{self.plugin}' ({self.distribution}): {self.target} of {NOUNS[self.kind]} '{self.name}' "
                f"cannot be imported: {one_line(error)}"
            ) from error


@dataclass(frozen=True)
class Plugin:
    """One entry point and how its loading went."""

    name: str
    distribution: str
    version: str
    module: str
    status: str
    """``ok``, ``broken``, ``incompatible`` or ``off`` (left out by HARNESS_PLUGINS)."""
    reason: str = ""
    registered: tuple[str, ...] = ()


@dataclass
class Registry:
    """All specs of all loaded plugins."""

    plugins: list[Plugin] = field(default_factory=list)
    specs: dict[tuple[str, str], list[Spec]] = field(default_factory=dict)

    def names(self, kind: str) -> list[str]:
        """Names of one kind, sorted."""
        return sorted(name for known_kind, name in self.specs if known_kind == kind)

    def get(self, kind: str, name: str) -> Spec:
        """The spec of a name.

        Raises:
            UsageError: Nobody registered the name; names the nearest match.
            PluginError: Two plugins claim the name; names both.
        """
        specs = self.specs.get((kind, name))
        if specs is None:
            raise UsageError(unknown_name(NOUNS[kind], name, self.names(kind)))
        if len(specs) > 1:
            raise PluginError(conflict(specs))
        return specs[0]

    def conflicts(self) -> list[str]:
        """One line for each name that several plugins claim."""
        return [conflict(specs) for specs in self.specs.values() if len(specs) > 1]


def unknown_name(noun: str, name: str, known: Iterable[str]) -> str:
    """One line: what was given, what there is, the nearest match."""
    known = sorted(known)
    return f"No {noun} '{name}'. There is: {', '.join(known) or 'none'}.{did_you_mean(name, known)}"


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """A question to add to a message; empty without a near match."""
    nearest = difflib.get_close_matches(name, known, n=1)
    return f" Did you mean '{nearest[0]}'?" if nearest else ""


def conflict(specs: list[Spec]) -> str:
    """One line that names everybody who claims one name."""
    owners = " and ".join(f"'{spec.plugin}' ({spec.distribution})" for spec in specs)
    first = specs[0]
    return (
        f"{sentence(NOUNS[first.kind])} '{first.name}' is claimed by the plugins {owners}: "
        "uninstall one, or name those to load in HARNESS_PLUGINS"
    )


def load_registry(found: Iterable[EntryPoint] | None = None) -> Registry:
    """Load the plugins one by one; a broken one is recorded and breaks nothing else.

    Args:
        found: Entry points to load; those of the installed distributions if None. The environment variable
            HARNESS_PLUGINS, where it is set, names those to load (comma separated; empty loads none).
    """
    registry = Registry()
    manager = pluggy.PluginManager(PROJECT)
    manager.add_hookspecs(Hooks)
    allowed = _allowed_plugins()
    candidates = entry_points(group=PROJECT) if found is None else found
    origins: dict[object, Origin] = {}
    for point in sorted(candidates, key=lambda point: (point.name, point.value)):
        # To ask a distribution for its name reads its metadata, each time; all plugins of one share the answer.
        origin = origins.get(point.dist) or _origin_of(point)
        if point.dist is not None:
            origins[point.dist] = origin
        if allowed is not None and point.name not in allowed:
            registry.plugins.append(_plugin(point, origin, "off", "not named in HARNESS_PLUGINS"))
            continue
        _load_plugin(point, origin, manager, registry)
    return registry


class Origin(NamedTuple):
    """Where a plugin comes from."""

    distribution: str
    version: str


def _origin_of(point: EntryPoint) -> Origin:
    return Origin(point.dist.name, point.dist.version) if point.dist else Origin(point.module, "")


def _allowed_plugins() -> set[str] | None:
    value = os.environ.get("HARNESS_PLUGINS")
    return None if value is None else {name.strip() for name in value.split(",")}


def _load_plugin(point: EntryPoint, origin: Origin, manager: pluggy.PluginManager, registry: Registry) -> None:
    try:
        module = point.load()
    except (Exception, SystemExit) as error:  # whatever a stranger's module does at import, the others go on
        registry.plugins.append(_plugin(point, origin, "broken", one_line(error)))
        return
    reason = _incompatibility(module, manager)
    if reason:
        registry.plugins.append(_plugin(point, origin, "incompatible", reason))
        return
    try:
        specs = _collect_specs(point, origin, module, manager)
    except (Exception, SystemExit) as error:  # the same for its hooks
        registry.plugins.append(_plugin(point, origin, "broken", one_line(error)))
        return
    for spec in specs:
        registry.specs.setdefault((spec.kind, spec.name), []).append(spec)
    registered = tuple(f"{NOUNS[spec.kind]} {spec.name}" for spec in specs)
    registry.plugins.append(_plugin(point, origin, "ok", registered=registered))


def _incompatibility(module: ModuleType, manager: pluggy.PluginManager) -> str:
    """Why a plugin does not fit these interfaces; empty if it does. Leaves it registered with `manager` if it does."""
    wanted = getattr(module, "harness_api", API_VERSION)
    if wanted != API_VERSION:
        return f"written for harness_api {wanted}, this is {API_VERSION}"
    if manager.is_registered(module):
        return "another entry point names the same module"
    try:
        manager.register(module)
    except pluggy.PluginValidationError as error:
        if manager.is_registered(module):  # newer pluggy takes it out by itself
            manager.unregister(module)
        return one_line(error)
    callers = manager.get_hookcallers(module) or []
    unknown = sorted(caller.name for caller in callers if not caller.has_spec())
    if unknown:
        manager.unregister(module)
        return f"no hook {', '.join(unknown)}; there is: {', '.join('register_' + kind for kind in KINDS)}"
    return "" if callers else "implements no hook: mark its functions with @harness.hookimpl"


def _collect_specs(point: EntryPoint, origin: Origin, module: ModuleType, manager: pluggy.PluginManager) -> list[Spec]:
    specs: list[Spec] = []
    others = [plugin for plugin in manager.get_plugins() if plugin is not module]
    for kind in KINDS:
        caller = manager.subset_hook_caller(f"register_{kind}", others)
        caller(register=_register_into(specs, kind, point.name, origin.distribution))
    return specs


def _register_into(specs: list[Spec], kind: str, plugin: str, distribution: str) -> Callable[..., None]:
    def register(
        name: str, target: str, *, summary: str, requires: Iterable[str] = (), extra: str | None = None
    ) -> None:
        if not _NAME.fullmatch(name):
            raise ValueError(f"register_{kind}: name {name!r} must be lower-case letters, digits, '-' and '_'")
        if not _TARGET.fullmatch(target):
            raise ValueError(f"register_{kind}: target {target!r} of '{name}' must be 'module:attribute'")
        if isinstance(requires, str):
            raise ValueError(f"register_{kind}: requires of '{name}' must be a list of modules, not a string")
        specs.append(Spec(kind, name, target, summary, tuple(requires), extra, plugin, distribution))

    return register


def _plugin(
    point: EntryPoint, origin: Origin, status: str, reason: str = "", registered: tuple[str, ...] = ()
) -> Plugin:
    return Plugin(point.name, origin.distribution, origin.version, point.module, status, reason, registered)


def _is_installed(module: str) -> bool:
    try:
        return importlib.util.find_spec(module) is not None
    except (ImportError, ValueError):
        return False
