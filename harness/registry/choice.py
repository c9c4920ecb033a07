"""What a user picks: a name with parameters, ``arp:k1=1,k2=1.5``.

A parameter may itself be such a text, ``scaled:reward=arp:k2=2,factor=3``; in parentheses, ``reward=(arp:k1=2,k2=3)``,
its commas are its own.
"""

import dataclasses
import re
import typing
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any, TypeAlias

import pydantic

from harness.errors import PluginError, UsageError, sentence
from harness.hookspecs import NOUNS
from harness.registry.members import require_members
from harness.registry.registry import BY_ID, Registry
from harness.registry.spec import Spec, blamed_on, did_you_mean
from harness.reward.forms import FAILED
from harness.reward.reward import is_finite
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


Defaults: TypeAlias = str | Callable[[Any], Mapping[str, Any]]
"""See `choose`."""
LONGEST = 10_000
"""Characters of a name with its parameters: a hundred times what a reward has."""
SYNTAX = "write name or name:key=value,key=value"
_NAME_WITH_PARAMS = re.compile(r"[\w./-]+:\w+=")


@dataclass(frozen=True)
class Choice:
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

    def to_json(self) -> dict[str, Any]:
        """Plain data; `from_json` gives the same choice back."""
        return {"name": self.name, "label": self.label, "params": {key: _plain(value) for key, value in self.params}}

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
        value = dict(self.params).get(name)
        if isinstance(value, bool) or not isinstance(value, int | float) or re.search(rf"[:,]{name}=", self.label):
            return self.label
        return f"{self.label}{',' if ':' in self.label else ':'}{name}={_text(value)}"

    def build(self, registry: Registry, kind: str) -> Any:
        """The chosen thing: the registered target, with these parameters."""
        return _build(registry.get(kind, self.name), dict(self.params), f"{NOUNS[kind]} '{self.name}'", registry)


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
        params[key.strip()] = _bare(value.strip())
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
    name, target = _recorded(spec, name), spec.load()
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


def _recorded(spec: Spec, typed: str) -> str:
    """What a manifest calls it: a plain name where that means it whatever else is installed, or where one was typed."""
    return spec.qualified if "/" in typed and not spec.is_built_in else spec.name


def _build(spec: Spec, params: Mapping[str, Any], noun: str, registry: Registry) -> Any:
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


def _bare(value: str) -> str:
    return value[1:-1].strip() if value.startswith("(") and value.endswith(")") else value


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


def _plain(value: Any) -> Any:
    return [_plain(item) for item in value] if isinstance(value, tuple) else value


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
