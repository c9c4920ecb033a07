"""The libraries that plugins need: which are installed, in which version, and which distribution brings them."""

import importlib.metadata
import importlib.util
import pkgutil
import re
from functools import lru_cache
from importlib.machinery import PathFinder

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
