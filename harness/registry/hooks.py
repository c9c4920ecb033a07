"""Whether a module's hooks are ones that exist, called as they are."""

import inspect
from collections.abc import Iterator
from types import FunctionType, ModuleType

from harness.hookspecs import KINDS, PROJECT
from harness.registry.names import did_you_mean

API_VERSION = 2
"""Version of the interfaces. A plugin may state the one it was written for as ``harness_api = 2``."""
HOOKS = tuple(f"register_{kind}" for kind in KINDS)
ARGUMENT = "register"
"""What every hook takes, by this name."""


def hooks_of(module: ModuleType) -> list[FunctionType]:
    """The functions of a module that are marked with ``@harness.hookimpl``."""
    return [it for it in vars(module).values() if isinstance(it, FunctionType) and hasattr(it, f"{PROJECT}_impl")]


def fault_of(module: ModuleType) -> str:
    """Why the hooks of a module cannot be called, with what was meant; empty if they can."""
    wanted = getattr(module, "harness_api", API_VERSION)
    if wanted != API_VERSION:
        return f"written for harness_api {wanted}, this is {API_VERSION}"
    faults = [fault for hook in hooks_of(module) for fault in _faults_of(hook)]
    faults += [f"{name} is not marked: write @harness.hookimpl above it" for name in _unmarked(module)]
    if faults:
        return "; ".join(faults)
    return "" if hooks_of(module) else "implements no hook: mark its functions with @harness.hookimpl"


def _faults_of(hook: FunctionType) -> Iterator[str]:
    name = _name_of(hook)
    if name not in HOOKS:
        yield f"there is no hook {name}.{did_you_mean(name, HOOKS) or ' There is: ' + ', '.join(HOOKS)}"
        return
    parameters = inspect.signature(hook).parameters
    needed = [it.name for it in parameters.values() if it.default is it.empty]
    if needed != [ARGUMENT]:
        yield f"{name}({', '.join(parameters)}) cannot be called: its one argument has to be named '{ARGUMENT}'"


def _name_of(hook: FunctionType) -> str:
    """The name of the hook that a function implements: mostly its own."""
    return getattr(hook, f"{PROJECT}_impl").get("specname") or hook.__name__


def _unmarked(module: ModuleType) -> list[str]:
    """Functions that are called like a hook and are none."""
    marked = {_name_of(hook) for hook in hooks_of(module)}
    return [
        name
        for name, it in vars(module).items()
        if name in HOOKS and name not in marked and isinstance(it, FunctionType) and it.__module__ == module.__name__
    ]
