"""Whatever plugins registered, and what a user picks of it: a name with parameters, ``arp:k1=1,k2=1.5``.

A parameter may itself be such a text, ``scaled:reward=arp:k2=2,factor=3``; in parentheses, ``reward=(arp:k1=2,k2=3)``,
its commas are its own. Nothing heavy is imported before a spec is loaded.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

from harness.errors import PluginError, UsageError, sentence
from harness.files.plain import Plain, tells
from harness.hookspecs import KINDS, NOUNS
from harness.registry.given import Given, PluginFile
from harness.registry.members import build, parameters_of, require_members, resolved, values_of
from harness.registry.spec import Spec, blamed_on, canonical, unknown_name

if TYPE_CHECKING:
    from harness.registry.step_functions import StepFunction


MENTIONED = 2
"""Plugins that did not load, in the message about a name that is not there."""


BY_ID = "gymnasium"
"""The name of the environment that an id of Gymnasium is short for."""


_ID = re.compile(r"-v\d+$")


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
        package = f"{self.distribution} {self.version}".rstrip()
        return f"plugin '{self.name}' of {package} is {self.status}: {self.reason}"


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
            others = ", ".join(NOUNS[it] for it in self.kinds_of(name))
            told = unknown_name(NOUNS[kind], name, self.typed_names(kind)) + self.not_loaded(kind, name)
            raise UsageError(f"'{name}' is of another kind: {others}. {told}" if others else told)
        found = _meant(specs)
        if found is None:
            raise PluginError(conflict(name.rpartition("/")[2], specs))
        return found

    def is_built_in(self, kind: str, name: str) -> bool:
        """Whether what is registered under a name is the harness's own; raises as `get` does."""
        return self.get(kind, name).is_built_in

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


Defaults: TypeAlias = str | Callable[[Any], Mapping[str, Any]]
"""See `choose`."""
LONGEST = 10_000
"""Characters of a name with its parameters: a hundred times what a reward has."""
SYNTAX = "write name or name:key=value,key=value"
_NAME_WITH_PARAMS = re.compile(r"[\w./-]+:\w+=")


@tells("name", "label", "params=named")
@dataclass(frozen=True)
class Choice(Plain):
    """A registered name with all its parameters, those left at their defaults included.

    Attributes:
        name: The registered name; qualified by its distribution where it was typed so, ``cem-algo/cem``.
        params: Every parameter with its value, in the order of the target's fields; JSON-able. Those that the target
            names in its class variable ``later`` are left out at their defaults.
        label: What to call it: the name, and the parameters that differ from their defaults.
    """

    name: str
    params: tuple[tuple[str, Any], ...] = ()
    label: str = ""

    @property
    def named(self) -> dict[str, Any]:
        """The parameters by their names."""
        return dict(self.params)

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> "Choice":
        """The choice that `to_json` wrote.

        Raises:
            ValueError: Its name or label has several lines, which would be taken for lines of ours.
        """
        for text in (data["name"], data["label"]):
            if not isinstance(text, str) or not _is_line(text):
                raise ValueError(f"{text!r} is no name")
        params = tuple((key, _frozen(value)) for key, value in data["params"].items())
        return cls(data["name"], params, data["label"])

    def label_with(self, name: str) -> str:
        """The label with a numeric parameter that it leaves out at its default; the label alone without such a one."""
        value = self.named.get(name)
        if isinstance(value, bool) or not isinstance(value, int | float) or re.search(rf"[:,]{name}=", self.label):
            return self.label
        return f"{self.label}{',' if ':' in self.label else ':'}{name}={_text(value)}"

    def build(self, registry: Registry, kind: str) -> Any:
        """The chosen thing: the registered target, with these parameters."""
        return _build(registry.get(kind, self.name), self.named, f"{NOUNS[kind]} '{self.name}'", registry)

    @contextmanager
    def blamed(self, registry: Registry, kind: str, doing: str) -> Iterator[None]:
        """Whatever is raised in this block is the fault of the plugin that was chosen; see `blamed_on`."""
        with blamed_on(registry.get(kind, self.name), doing):
            yield


def choose(registry: Registry, kind: str, given: str | Mapping[str, Any], defaults: Defaults = "") -> Choice:
    """Resolve what a user gave: ``"arp:k2=2"`` or ``{"name": "arp", "k2": 2}``.

    Args:
        registry: The plugins.
        kind: Of what is named.
        given: The name, with the parameters that the user chose.
        defaults: The name of a class variable of the target, such as ``in_environments``. It holds values that take the
            place of the target's defaults. The choice is then the same as if the user had written them. Or a function
            that returns such values, given the target with its own defaults.

    Raises:
        UsageError: Unknown name, malformed text, unknown parameter, wrong type or value out of range.
        PluginError: The plugin behind the name is broken, or declares defaults that it does not take; says whose it is.
    """
    return _choose_and_build(registry, kind, given, defaults)[0]


def build_defaults(registry: Registry, kind: str, names: Iterable[str] | None = None) -> dict[str, Any]:
    """Things of one kind with their default parameters, by name: those of `names`, by default every registered one.

    Raises:
        UsageError: A name is not registered, or a library that it requires is missing.
        PluginError: A target cannot be imported.
    """
    chosen = registry.names(kind) if names is None else names
    return {name: Choice(name).build(registry, kind) for name in chosen}


def build_named(registry: Registry, kind: str, text: str, within: str) -> tuple[str, Any]:
    """What a plugin's parameter names, for plugins that build on another: its label, and the thing itself.

    Args:
        registry: The plugins.
        kind: Of the plugin and of what is named; the parameter is its singular: ``reward`` for ``rewards``.
        text: What the parameter holds, ``arp:k2=2``.
        within: The plugin's own name. It may not come again in `text`: without this, names could be nested forever.

    Raises:
        UsageError: `within` is named again, or as `choose`.
    """
    inner = text
    while inner:
        name, params = parse(inner)
        if name == within:
            raise UsageError(f"{sentence(NOUNS[kind])} '{within}' is given '{text}': it cannot stand inside itself")
        inner = params.get(NOUNS[kind], "")
    choice, built = _choose_and_build(registry, kind, text)
    return choice.label, built


def split_list(given: str | Iterable[str]) -> list[str]:
    """Split ``a,b:x=1,y=2,c`` into ``a``, ``b:x=1,y=2`` and ``c``.

    A comma starts a new name unless ``key=value`` follows, which belongs to the name before it. Commas in parentheses
    stay.

    Raises:
        UsageError: A text is too long.
    """
    texts = [given] if isinstance(given, str) else list(given)
    names: list[str] = []
    for text in texts:
        _require_short(text)
        for index, part in enumerate(_split(text)):
            belongs = index > 0 and "=" in part and ":" not in part.split("=")[0]
            if belongs and ":" in names[-1]:
                names[-1] += "," + part
            else:
                names.append(part.strip())
    return names


def parse(text: str) -> tuple[str, dict[str, str]]:
    """Split ``name:key=value,key=value`` into the name and its parameters, still text.

    Raises:
        UsageError: The text is malformed, or too long.
    """
    _require_short(text)
    name, colon, rest = text.partition(":")
    if not name or "=" in name or (colon and not rest) or text.count("(") != text.count(")"):
        raise UsageError(f"'{text}' is malformed: {SYNTAX}")
    params: dict[str, str] = {}
    for part in _split(rest) if rest else []:
        key, equals, value = part.partition("=")
        if not (key.strip() and equals and value.strip()):
            raise UsageError(f"'{part}' in '{text}' is malformed: {SYNTAX}")
        if key.strip() in params:
            raise UsageError(f"'{key.strip()}' is given twice in '{text}'")
        value = value.strip()
        params[key.strip()] = value[1:-1].strip() if value.startswith("(") and value.endswith(")") else value
    return name.strip(), params


def label_of(name: str, changed: Mapping[str, Any]) -> str:
    """What to call a choice: its name, and the parameters that differ from their defaults."""
    text = ",".join(f"{key}={_text(value)}" for key, value in changed.items())
    return f"{name}:{text}" if text else name


def _require_short(text: str) -> None:
    if len(text) > LONGEST:
        raise UsageError(f"'{text[:20]}...' has {len(text):,} characters, {LONGEST:,} are allowed: {SYNTAX}")


def _choose_and_build(
    registry: Registry, kind: str, given: str | Mapping[str, Any], defaults: Defaults = ""
) -> tuple[Choice, Any]:
    """The choice, and what was built to check it: a name inside a name costs no second one."""
    name, params = parse(given) if isinstance(given, str) else _name_and_params(given)
    noun = f"{NOUNS[kind]} '{name}'"
    spec = registry.get(kind, name)
    if name.rpartition("/")[2] not in spec.claims:  # an id that it makes
        name, params = spec.name, {"id": name, **params}
    # What a manifest calls it: a plain name where that means it whatever else is installed, or where one was typed.
    name, target = spec.qualified if "/" in name and not spec.is_built_in else spec.name, spec.load()
    if isinstance(given, str):
        params = _hand_inwards(params, {parameter.name for parameter in parameters_of(target)})
    built = _build(spec, params, noun, registry)
    declared = _not_chosen(target, built, params, defaults)
    if declared:
        try:
            built = _build(spec, {**params, **declared}, noun, registry)
        except UsageError as error:
            told = defaults if isinstance(defaults, str) else "defaults_for"
            raise PluginError(f"{spec.title} does not take what its {told} declares: {error}") from error
    values, changed = resolved(target, built, noun)
    later = set(getattr(target, "later", ())) - changed.keys()
    frozen = tuple((key, _frozen(value)) for key, value in values.items() if key not in later)
    label = label_of(name, changed)
    if not _is_line(label):
        raise UsageError(f"'{label}' has line breaks: {SYNTAX}")
    return Choice(name, frozen, label), built


def _not_chosen(target: Any, built: Any, params: Mapping[str, Any], defaults: Defaults) -> dict[str, Any]:
    """What the target declares in place of its defaults, but for what was given, or brought by a preset that was."""
    of_class = getattr(target, defaults, {}) if isinstance(defaults, str) and defaults else {}
    declared: Mapping[str, Any] = of_class if isinstance(defaults, str) else defaults(built)
    brought = target.defaults_with(values_of(built)) if declared and hasattr(target, "defaults_with") else {}
    return {key: value for key, value in declared.items() if key not in params and key not in brought}


def _build(spec: Spec, params: Mapping[str, Any], noun: str, registry: Registry) -> Any:
    from harness.reward.forms import FAILED  # numpy: what is only named needs none

    target = spec.load()
    if params and (failed := getattr(target, FAILED, "")):  # its parameters are not known
        raise UsageError(failed)
    with blamed_on(spec, "it was built"):
        built = build(target, params, noun, registry)
    require_members(spec, built)
    return built


def _is_line(text: str) -> bool:
    return text.splitlines() in ([], [text])


def _split(text: str) -> list[str]:
    """Parts between the commas that stand in no parentheses."""
    depth, parts = 0, [""]
    for char in text:
        depth = max(0, depth + (char == "(") - (char == ")"))
        if char == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += char
    return parts


def _hand_inwards(params: dict[str, str], known: set[str]) -> dict[str, str]:
    """In ``scaled:reward=arp:k1=2,k2=3,factor=4`` k2 is no parameter of scaled: it belongs to arp, before it."""
    kept: dict[str, str] = {}
    last = ""
    for key, value in params.items():
        if key not in known and _NAME_WITH_PARAMS.match(kept.get(last, "")):
            kept[last] += f",{key}={_text(value)}"
        else:
            kept[key], last = value, key
    return kept


def _name_and_params(given: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    params = dict(given)
    name = params.pop("name", None)
    if not isinstance(name, str):
        raise UsageError(f"{dict(given)} has no name: write {{name = '...', key = value}}")
    return name, params


def _frozen(value: Any) -> Any:
    return tuple(_frozen(item) for item in value) if isinstance(value, list | tuple) else value


def _text(value: Any) -> str:
    if isinstance(value, list | tuple):
        return "x".join(_text(item) for item in value)
    if isinstance(value, float) and float(f"{value:g}") == value:
        return f"{value:g}"
    text = str(value)
    return f"({text})" if "," in text or text.startswith("(") else text


PLACES = ("tasks", "environments")
"""The kinds of what ``--task`` may name."""


def kind_of_task(given: Any, registry: Registry) -> str:
    """Whether a name is that of a task or of an environment: ``"tasks"`` or ``"environments"``; the former of neither.

    Raises:
        UsageError: It is both.
    """
    name = str(_name_of(given))
    kinds = [kind for kind in registry.kinds_of(name) if kind in PLACES]
    if len(kinds) > 1:
        claims = " and ".join(
            f"{spec.kind[:-1]} of package {spec.package}" for spec in (registry.get(kind, name) for kind in PLACES)
        )
        raise UsageError(f"'{name}' is both a task and an environment: {claims}. Leave one out with HARNESS_PLUGINS")
    return kinds[0] if kinds else "tasks"


def require_known(task: Any, registry: Registry) -> None:
    """Check that a task is registered.

    Raises:
        UsageError: It is not; names the environments too, of which it might have been one.
    """
    try:
        registry.get("tasks", str(_name_of(task)))
    except UsageError as error:
        there = f" Environments: {', '.join(registry.names('environments')) or 'none'}."
        told, asks, question = str(error).partition(" Did you mean")
        by_id = [it.load() for it in registry.specs.get(("environments", BY_ID), ()) if it.is_built_in]
        near = "".join(it.near(str(_name_of(task))) for it in by_id)
        raise UsageError(f"{told}{there}{near}{asks}{question}") from None


def _name_of(given: Any) -> Any:
    return parse(given)[0] if isinstance(given, str) else given.get("name")
