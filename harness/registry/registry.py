"""Who registered what: entry points in, specs out. Nothing heavy is imported before a spec is loaded."""

import os
import re
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from importlib.metadata import Distribution, EntryPoint, entry_points
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import pluggy

from harness.errors import PluginError, UsageError, one_line, sentence
from harness.hookspecs import KINDS, NOUNS, PROJECT, Hooks
from harness.registry.given import Given, PluginClass, PluginFile
from harness.registry.plugin_module import class_of_file, import_file
from harness.registry.spec import OURS, Spec, canonical, did_you_mean, fault_of, hooks_of, module_of, unknown_name

if TYPE_CHECKING:
    from harness.registry.step_functions import StepFunction


MENTIONED = 2
"""Plugins that did not load, in the message about a name that is not there."""

BY_ID = "gymnasium"
"""The name of the environment that an id of Gymnasium is short for."""
_ID = re.compile(r"-v\d+$")
_NAME = re.compile(r"[a-z0-9][a-z0-9_-]*")
_TARGET = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*")


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
    own: tuple[str, ...] = ()
    """In a file of rewards or measures: the functions that are none, ``clip(x)``."""

    @property
    def is_at_fault(self) -> bool:
        """Whether somebody has to mend it."""
        return self.status in {"broken", "incompatible"}

    @property
    def complaint(self) -> str:
        """A line that says whose it is and what is wrong with it."""
        return f"{self._title} is {self.status}: {self.reason}"

    @property
    def _title(self) -> str:
        package = f"{self.distribution} {self.version}".rstrip()
        return f"plugin '{self.name}' of {package}"


@dataclass
class Registry:
    """All specs of all loaded plugins.

    Attributes:
        plugins: Every plugin, loaded or not.
        specs: By kind and name, who claims the name, be it short for another name of theirs.
        notes: What there is to say of the environment variable HARNESS_PLUGINS.
        given: What was given by hand: whoever does the work elsewhere needs it too.
        functions: Rewards and measures for steps of environments, in the order in which their files were given.
    """

    plugins: list[Plugin] = field(default_factory=list)
    specs: dict[tuple[str, str], list[Spec]] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    given: tuple[Given, ...] = ()
    functions: "list[StepFunction]" = field(default_factory=list)

    def functions_of(self, noun: str) -> "dict[str, StepFunction]":
        """Those that are a ``reward``, or those that are a ``measure``, by name."""
        return {it.name: it for it in self.functions if it.noun == noun}

    def names(self, kind: str) -> list[str]:
        """Every name of one kind that can be used, sorted; a qualified one where the plain one means another's."""
        return sorted(
            usable
            for (known_kind, name), specs in self.specs.items()
            if known_kind == kind
            for usable in _usable_names(name, specs)
        )

    def short_names(self, kind: str) -> dict[str, str]:
        """What is short for a name of one kind, and that name."""
        specs = (self.get(kind, name) for name in self.names(kind))
        return {it.short: it.name for it in specs if it.short and _meant(self.specs[kind, it.short]) is it}

    def typed_names(self, kind: str) -> list[str]:
        """`names` and `short_names`, sorted."""
        return sorted({*self.names(kind), *self.short_names(kind)})

    def get(self, kind: str, name: str) -> Spec:
        """The spec of a name, of what is short for one, or of a qualified one such as ``cem-algo/cem``.

        A plain name that the harness itself brings is always its own, whoever claims it too.

        Raises:
            UsageError: Nobody registered the name; names the nearest match, and plugins that did not load.
            PluginError: Several plugins claim the name; names their qualified names.
        """
        specs = self._claimed(kind, name)
        if not specs:
            raise UsageError(unknown_name(NOUNS[kind], name, self.typed_names(kind)) + self.not_loaded(kind, name))
        found = _meant(specs)
        if found is None:
            raise PluginError(conflict(name.rpartition("/")[2], specs))
        return found

    def _claimed(self, kind: str, name: str) -> list[Spec]:
        """Who claims a name, or a qualified one."""
        distribution, _, bare = name.rpartition("/")
        specs = self.specs.get((kind, bare), [])
        found = [it for it in specs if not distribution or canonical(it.distribution) == canonical(distribution)]
        by_id = self.specs.get((kind, BY_ID), []) if not found and _ID.search(name) else []
        return found or [it for it in by_id if it.is_built_in and it.load().knows(name)]

    def all_specs(self) -> Iterator[Spec]:
        """Whatever was registered."""
        return (spec for (_, name), specs in self.specs.items() for spec in specs if spec.name == name)

    def kinds_of(self, name: str) -> list[str]:
        """The kinds of which something has this name, or this qualified name."""
        return [kind for kind in KINDS if self._claimed(kind, name)]

    def all_names(self) -> set[str]:
        """Every name of every kind that can be typed."""
        return {name for kind in KINDS for name in self.typed_names(kind)}

    def conflicts(self) -> list[str]:
        """One line for each name that several plugins claim."""
        return [conflict(name, specs) for (_, name), specs in self.specs.items() if len(specs) > 1]

    def needs(self, in_environment: bool) -> list[dict[str, Any]]:
        """What an experiment file says of the plugins that were given by hand; of those that could be loaded.

        Args:
            in_environment: Whether what functions say of each step is recorded, so that no report needs their files.
        """
        broken = {it.name for it in self.plugins if it.is_at_fault}
        recorded = {it.file for it in self.functions} if in_environment else set()
        return [
            {**it.need, **({"functions": True} if it in recorded else {})} for it in self.given if it.name not in broken
        ]

    def broken_files(self) -> list[str]:
        """A line for each file that a pattern found and that cannot be loaded."""
        names = {it.name for it in self.given if isinstance(it, PluginFile) and it.optional}
        return [f"Left out: {it.reason}" for it in self.plugins if it.is_at_fault and it.name in names]

    def complaints(self) -> list[str]:
        """What there is to know before names are used: plugins that did not load, names that several claim."""
        at_fault = [sentence(plugin.complaint) for plugin in self.plugins if plugin.is_at_fault]
        return [*at_fault, *self.conflicts(), *self.notes]

    def why_no_reward(self, name: str) -> str:
        """Why a name is that of a function in a file and of no reward; empty if it is no such name."""
        from harness.registry.step_functions import why_no_reward  # here, as in `_load_file`

        told = ((plugin.name, why_no_reward(name, plugin.own)) for plugin in self.plugins)
        return next((f"In {file}, {why}" for file, why in told if why), "")

    def not_loaded(self, kind: str = "", name: str = "") -> str:
        """What may be the reason that a name is not there, to follow on a message; empty if nothing may."""
        function = self.functions_of("reward").get(name) if kind == "rewards" else None
        if function is not None:
            return (
                f" {function.told} pays in environments, the arm's own among them: --task harness/Reach-v0, which "
                "takes no --sim. In its other runs write a function of step, or a frozen dataclass with initial_carry"
            )
        called = next((it for it in self.functions if it.attribute == name and kind == "rewards"), None)
        if called is not None:
            return f" In {called.file.name}, {called.attribute} is called '{called.name}', as its file"
        if kind == "rewards" and (own := self.why_no_reward(name)):
            return f" {own}"
        at_fault = [plugin for plugin in self.plugins if plugin.is_at_fault]
        more = f" and {len(at_fault) - MENTIONED} more" if len(at_fault) > MENTIONED else ""
        told = "; ".join(plugin.complaint for plugin in at_fault[:MENTIONED])
        return f" Not loaded: {told}{more}" if told else ""


def conflict(name: str, specs: list[Spec]) -> str:
    """One line that names everybody who claims one name, and what to write instead."""
    meant = _meant(specs)
    what = f"{sentence(NOUNS[specs[0].kind])} '{name}'"
    if meant is not None:
        others = [spec for spec in specs if spec is not meant]
        owners = " and ".join(f"package {spec.package}" for spec in others)
        written = " or ".join(spec.qualified for spec in others)
        return f"{what} is the built-in one. It is claimed by {owners} too: write {written} for that"
    owners = " and ".join(f"'{spec.plugin}' ({spec.package})" for spec in specs)
    written = " or ".join(dict.fromkeys(spec.qualified for spec in specs))
    instead = f"write {written}, or leave" if len({spec.qualified for spec in specs}) == len(specs) else "leave"
    return f"{what} is claimed by the plugins {owners}: {instead} one out with HARNESS_PLUGINS=-{specs[-1].plugin}"


def _meant(specs: list[Spec]) -> Spec | None:
    """The spec meant by a name that several claim: the only one, or the harness's own; None if nobody can tell."""
    ours = [spec for spec in specs if spec.is_built_in]
    candidates = ours or specs
    return candidates[0] if len(candidates) == 1 else None


def _usable_names(name: str, specs: list[Spec]) -> Iterator[str]:
    """The names of specs that claim one name: the plain name, and the qualified names of the others.

    A spec for which the name is short has another name of its own.
    """
    meant = _meant(specs)
    owners = [canonical(spec.distribution) for spec in specs]
    for spec in specs:
        if spec.name != name:
            continue
        if spec is meant:
            yield name
        elif owners.count(canonical(spec.distribution)) == 1:
            yield spec.qualified


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
    from harness.registry.step_functions import functions_of_file, own_functions

    module = import_file(file)
    functions = [] if hooks_of(module) else functions_of_file(file, module)
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
