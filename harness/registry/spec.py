"""A name that users type and the object behind it."""

import importlib
import re
import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from harness.errors import HarnessError, PluginError, UsageError, one_line, sentence
from harness.hookspecs import NOUNS
from harness.registry.libraries import is_met, module_of

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
        from harness.reward.forms import is_function_of_steps, reward_class

        return reward_class(target) if is_function_of_steps(target) else target
    return target


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
