"""A name that users type and the object behind it."""

import importlib
import importlib.util
import pkgutil
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.machinery import PathFinder
from typing import Any

from harness.errors import HarnessError, PluginError, UsageError, one_line, sentence
from harness.hookspecs import NOUNS

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
        """Whose it is, to begin a message with: ``Algorithm 'cem' of package cem-algo 0.1``."""
        return f"{sentence(NOUNS[self.kind])} '{self.name}' of package {self.package}"

    @property
    def missing(self) -> tuple[str, ...]:
        """The required modules that are not installed."""
        return tuple(module for module in self.requires if not is_installed(module))

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
                f"Plugin '{self.plugin}' ({self.package}): {self.target} of {NOUNS[self.kind]} '{self.name}' "
                f"cannot be imported: {one_line(error)}"
            ) from error


@contextmanager
def blamed_on(spec: Spec, doing: str) -> Iterator[None]:
    """Whatever a plugin raises in this block is the plugin's fault, and said so.

    Args:
        spec: Whose code runs.
        doing: What for, ``it was built``.

    Raises:
        PluginError: It raised something that is no error of ours, or wanted to leave.
    """
    try:
        yield
    except HarnessError:
        raise
    except (Exception, SystemExit) as error:
        raise PluginError(f"{spec.title} raised {one_line(error)} while {doing}") from error


def canonical(distribution: str) -> str:
    """The name of a distribution as all its spellings have it: lower-case, with hyphens."""
    return re.sub(r"[-_.]+", "-", distribution).lower()


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
