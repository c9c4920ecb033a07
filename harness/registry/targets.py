"""Whether a registered target is what its kind asks for: looked for without importing it, or imported and compared."""

import dataclasses
import importlib.util
import inspect
import re
import symtable
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

from harness.errors import HarnessError, one_line
from harness.registry.choice import Plugin, Registry
from harness.registry.members import missing_members, sample_of
from harness.registry.spec import Spec, did_you_mean

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
    missing = missing_members(spec.kind, sample_of(target))
    return f"{spec.title} {missing}" if missing else ""


def examined(registry: Registry) -> list[Plugin]:
    """Every plugin of a registry, as broken where a target that it registered cannot be found, see `why_absent`."""
    absent: dict[tuple[str, str], list[str]] = {}
    for spec in registry.all_specs():
        if reason := why_absent(spec):
            absent.setdefault((spec.plugin, spec.distribution), []).append(reason)
    return [
        replace(it, status="broken", reason="; ".join(absent[owner]))
        if (owner := (it.name, it.distribution)) in absent
        else it
        for it in registry.plugins
    ]


def _names_in(source: str, path: str) -> set[str]:
    """What a module binds at its top level."""
    table = symtable.symtable(source, path, "exec")
    return {symbol.get_name() for symbol in table.get_symbols() if symbol.is_assigned() or symbol.is_imported()}


def _no_name(spec: Spec, names: Any) -> str:
    module, attribute = spec.target.split(":")
    return f"{spec.title}: module '{module}' has no '{attribute}'.{did_you_mean(attribute, names)}"
