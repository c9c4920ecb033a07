"""Whether a registered target is what its kind asks for: looked for without importing it, or imported and compared."""

import dataclasses
import importlib.util
import inspect
import re
import symtable
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from harness.errors import HarnessError, PluginError, one_line
from harness.hookspecs import NOUNS
from harness.registry.names import did_you_mean
from harness.registry.registry import Plugin, Registry
from harness.registry.spec import Spec

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
        "executors": {"run": 3},
    }
)
"""What a target of each kind must have: of a method how many arguments it is called with, of a value None."""
_STAR = re.compile(r"^\s*from\s+\S+\s+import\s+\*", re.MULTILINE)


def why_absent(spec: Spec) -> str:
    """Why a target cannot be found: its module or the name in it does not exist. Empty if nothing speaks against it.

    The module is not imported, only read; the packages around it are imported. It takes about a millisecond.
    """
    module, attribute = spec.target.split(":")
    if module in sys.modules:
        return "" if hasattr(sys.modules[module], attribute) else _no_name(spec, dir(sys.modules[module]))
    try:
        found = importlib.util.find_spec(module)
        if found is None:
            return f"{spec.title}: there is no module '{module}'"
        if not (found.origin and found.origin.endswith(".py")):
            return ""  # compiled, or of a loader of its own: it cannot be read
        source = Path(found.origin).read_text(encoding="utf-8")
        names = _names_in(source, found.origin)
    except (Exception, SystemExit) as error:  # a package around it may do anything at import
        return f"{spec.title}: {spec.target} cannot be found: {one_line(error)}"
    return "" if attribute in names or "__getattr__" in names or _STAR.search(source) else _no_name(spec, names)


def why_unfit(spec: Spec) -> str:
    """Why a target is not what its kind asks for; imports it. Empty if it has every member with the right call.

    A library that it requires and that is not installed is no fault of the target, see `Spec.missing`: its target is
    looked for, as by `why_absent`.
    """
    if spec.missing:
        return why_absent(spec)
    try:
        target = spec.load()
    except HarnessError as error:
        return str(error)
    if spec.kind == "robots":
        is_folder = isinstance(target, Path) and (target / "robot.toml").is_file()
        return "" if is_folder else f"{spec.title}: {target!r} is no folder with a robot.toml"
    if spec.kind == "commands":
        return "" if callable(target) else f"{spec.title}: {target!r} is no function"
    if not (inspect.isclass(target) and dataclasses.is_dataclass(target)):
        return f"{spec.title}: {target!r} is no dataclass"
    missing = missing_members(spec.kind, _sample_of(target))
    return f"{spec.title} {missing}" if missing else ""


def examined(registry: Registry) -> list[Plugin]:
    """Every plugin of a registry, as broken where a target that it registered does not exist; see `why_absent`."""
    absent: dict[tuple[str, str], list[str]] = {}
    for spec in registry.all_specs():
        if reason := why_absent(spec):
            absent.setdefault((spec.plugin, spec.distribution), []).append(reason)
    found = {owner: "; ".join(reasons) for owner, reasons in absent.items()}
    owners = [(plugin.name, plugin.distribution) for plugin in registry.plugins]
    return [
        replace(plugin, status="broken", reason=found[owner]) if owner in found else plugin
        for plugin, owner in zip(registry.plugins, owners, strict=True)
    ]


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
        return f"has no {', '.join(lacking)}; {_article(NOUNS[kind])} has {', '.join(members)}"
    for name, count in members.items():
        if count is not None and not _takes(getattr(thing, name), count + inspect.isclass(thing)):
            arguments = f"{count} argument{'s' * (count != 1)}"
            return f"cannot be called as it has to be: {name} takes {arguments} beside self"
    return ""


def _sample_of(target: Any) -> Any:
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


def _article(noun: str) -> str:
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def _names_in(source: str, path: str) -> set[str]:
    """What a module binds at its top level."""
    table = symtable.symtable(source, path, "exec")
    return {symbol.get_name() for symbol in table.get_symbols() if symbol.is_assigned() or symbol.is_imported()}


def _no_name(spec: Spec, names: Any) -> str:
    module, attribute = spec.target.split(":")
    return f"{spec.title}: module '{module}' has no '{attribute}'.{did_you_mean(attribute, names)}"
