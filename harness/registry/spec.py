"""A name that users type and the object behind it."""

import difflib
import glob
import importlib
import importlib.metadata
import importlib.util
import inspect
import os
import pkgutil
import re
import shlex
from collections.abc import Iterable, Iterator
from contextlib import chdir, contextmanager
from dataclasses import dataclass
from functools import lru_cache
from importlib.machinery import PathFinder
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

from harness.errors import HarnessError, PluginError, UsageError, one_line, sentence
from harness.hookspecs import KINDS, NOUNS, PROJECT

_NEED = re.compile(r"(?P<module>[A-Za-z_][\w.]*)(?:>=(?P<version>\d+(?:\.\d+)*))?")


def module_of(need: str) -> str:
    """The module of a need, ``mujoco`` of ``mujoco>=3.17``.

    Raises:
        ValueError: It is neither the name of a module nor one with its least version.
    """
    return _parsed(need)[0]


def is_met(need: str) -> bool:
    """Whether a module can be found, in the version that is needed if one is named, ``mujoco>=3.17``."""
    module, least = _parsed(need)
    return is_installed(module) and (not least or _numbers(version_of(distribution_of(module))) >= _numbers(least))


def _parsed(need: str) -> tuple[str, str]:
    found = _NEED.fullmatch(need)
    if found is None:
        raise ValueError(f"'{need}' is neither a module nor a module with its least version, such as 'mujoco>=3.17'")
    return found["module"], found["version"] or ""


def _numbers(version: str) -> tuple[int, ...]:
    """The numbers that a version begins with, ``(3, 17)`` of ``3.17.0rc1``; zeros at its end do not count."""
    numbers = [int(part) for part in (re.match(r"\d+(?:\.\d+)*", version) or [""])[0].split(".") if part]
    while numbers and not numbers[-1]:
        numbers.pop()
    return tuple(numbers)


def is_installed(module: str) -> bool:
    """Whether a module can be found; the packages that it stands in are not imported."""
    package, *parts = module.split(".")
    try:
        found = importlib.util.find_spec(package)
        for part in parts:
            folders = [] if found is None else found.submodule_search_locations or []
            places = pkgutil.extend_path([*folders], package)  # several distributions may fill a package
            package = f"{package}.{part}"
            found = PathFinder.find_spec(package, places)
    except (ImportError, ValueError):
        return False
    return found is not None


def distribution_of(module: str) -> str:
    """Name of the distribution that brings a module: mostly the module's own, as ``dm-control`` for ``dm_control``.

    A module in a package may come by a distribution of its own, as ``mujoco.mjx`` by ``mujoco-mjx``.
    """
    name = module.partition(".")[0].replace("_", "-")
    for own in dict.fromkeys([re.sub(r"[._]", "-", module), name]):
        if version_of(own):
            return own
    # To ask all distributions takes a fifth of a second, which every cell would wait for.
    found = importlib.metadata.packages_distributions().get(module.partition(".")[0], [name])
    return found[0]


def version_of(distribution: str) -> str:
    """The version of an installed distribution; empty if it is not installed."""
    try:
        return _installed_version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return ""


@lru_cache(maxsize=256)  # what a process runs, it loaded before; to ask reads all of the distribution's metadata
def _installed_version(distribution: str) -> str:
    return importlib.metadata.version(distribution)


def unknown_name(noun: str, name: str, known: Iterable[str]) -> str:
    """The message that there is no such name, and which there are, with the nearest one.

    Args:
        noun: What it should name, ``reward``.
        name: As it was given.
        known: The names that there are, in any order.
    """
    known, file = sorted(known), f"{name.removesuffix('.py')}.py"
    meant = f" The file here needs --plugin {file}" if os.path.isfile(file) else did_you_mean(name, known)
    return f"No {noun} '{name}'. There is: {', '.join(known) or 'none'}.{meant}"


def nothing_at(path: Path, noun: str = "folder or file") -> str:
    """The message that nothing lies at a path, with the nearest name of what lies beside it."""
    below = glob.glob(os.path.join(glob.escape(str(path.parent)), "*", glob.escape(path.name)))  # one folder too high
    beside = [it.name for it in path.parent.glob("*")]
    meant = f" Did you mean '{Path(below[0])}'?" if below else did_you_mean(path.name, beside)
    return f"No {noun} '{path}'.{meant}"


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """A question to add to a message; empty without a near match."""
    nearest = difflib.get_close_matches(name, list(known), n=1)
    return f" Did you mean '{nearest[0]}'?" if nearest else ""


OURS = "fd100-harness"
"""The distribution whose plugins are built in."""

PLANNED = "the experiment was planned"
"""What plugins are asked for before anything runs."""


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
    version: str = ""
    heading: str = ""
    short: str = ""
    """What may be typed in place of the name; records have the name."""

    @property
    def claims(self) -> tuple[str, ...]:
        """The names that mean it, unless somebody else has them: its own, and the short one if it has one."""
        return tuple(dict.fromkeys(filter(None, (self.name, self.short))))

    @property
    def is_built_in(self) -> bool:
        """Whether the harness itself brings it."""
        return self.distribution == OURS

    @property
    def qualified(self) -> str:
        """The name that no other distribution can claim, ``cem-algo/cem``."""
        return f"{self.distribution}/{self.name}"

    @property
    def package(self) -> str:
        """Distribution and version, ``cem-algo 0.1``."""
        return f"{self.distribution} {self.version}".strip()

    @property
    def title(self) -> str:
        """The name with its owner, to begin a message with: ``Algorithm 'cem' of package cem-algo 0.1``."""
        return f"{sentence(NOUNS[self.kind])} '{self.name}' of package {self.package}"

    @property
    def modules(self) -> tuple[str, ...]:
        """The modules that it requires, without their versions."""
        return tuple(map(module_of, self.requires))

    @property
    def missing(self) -> tuple[str, ...]:
        """What it requires and is not installed, or only in an older version."""
        return tuple(need for need in self.requires if not is_met(need))

    @property
    def remedy(self) -> str:
        """What to type to get what is missing."""
        return (
            f"pip install '{self.distribution}[{self.extra}]'"
            if self.extra
            else "pip install " + shlex.join(self.missing)
        )

    def load(self) -> Any:
        """Import the target.

        Raises:
            UsageError: A required library is not installed, or a function reads what no step has, or fails.
            PluginError: The target cannot be imported or does not exist.
        """
        if self.missing:
            raise UsageError(
                f"{sentence(NOUNS[self.kind])} '{self.name}' needs {', '.join(self.missing)}: {self.remedy}"
            )
        module, attribute = self.target.split(":")
        try:
            with chdir("."):  # the module may change it
                return _as_class(self.kind, getattr(importlib.import_module(module), attribute))
        except UsageError:  # a function of steps that cannot measure
            raise
        except (Exception, SystemExit) as error:
            raise PluginError(
                f"Plugin '{self.plugin}' ({self.package}): {self.target} of {NOUNS[self.kind]} '{self.name}' "
                f"cannot be imported: {one_line(error)}"
            ) from error


def _as_class(kind: str, target: Any) -> Any:
    """The class that stands for a metric or a reward that is a plain function; everything else as it is."""
    if kind == "metrics":  # imported here, since most commands only name plugins
        from harness.registry.measure_functions import is_measure_function, measure_class

        return measure_class(target) if is_measure_function(target) else target
    if kind == "rewards":
        from harness.reward.forms import STEP, reward_class, takes_alone

        return reward_class(target) if takes_alone(target, STEP) else target
    return target


@contextmanager
def blamed_on(spec: Spec, doing: str) -> Iterator[None]:
    """Whatever a plugin raises in this block is the plugin's fault, and said so. The current folder stays what it was.

    Args:
        spec: Whose code runs.
        doing: What for, ``it was built``.

    Raises:
        PluginError: It raised something that is no error of ours, or wanted to leave.
    """
    try:
        with chdir("."):
            yield
    except HarnessError:
        raise
    except (Exception, SystemExit) as error:
        raise PluginError(f"{spec.title} raised {one_line(error)} while {doing}") from error


def canonical(distribution: str) -> str:
    """The name of a distribution as all its spellings have it: lower-case, with hyphens."""
    return re.sub(r"[-_.]+", "-", distribution).lower()


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
        return (
            f"written for harness_api {wanted}, this is {API_VERSION}: run its tests with `harness check`, change what "
            f"docs/plugins.md lists, and write harness_api = {API_VERSION}"
        )
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


def require_pillow() -> None:
    """See whether pillow is there.

    Raises:
        UsageError: It is missing.
    """
    try:
        import PIL  # noqa: F401
    except ImportError as error:
        raise UsageError("Pictures of the arm need pillow: pip install 'fd100-harness[video]'") from error
