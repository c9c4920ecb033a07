"""What was asked to be checked, what is known of the checks before they are run, and what they found."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

from harness.registry import read_given
from harness.registry.given import PluginFile, is_class_name


@dataclass(frozen=True)
class Asked:
    """A plugin or a robot, as the user named it. Nothing of it has been imported.

    Attributes:
        name: A registered name, with parameters or without: ``arp:k2=2``; of a robot also a path.
        kind: ``rewards`` or ``reward`` and so on; None: the kind that has the name.
        robot: The arm that a simulator or a task is checked with; None: fd100, or the task's own.
        files: Plugin files that were given by hand, with their text.
        classes: Classes that were given by hand, as ``module:Class``.
    """

    name: str
    kind: str | None = None
    robot: str | None = None
    files: tuple[PluginFile, ...] = ()
    classes: tuple[str, ...] = ()


def read_plugins(given: Sequence[str]) -> tuple[tuple[PluginFile, ...], tuple[str, ...]]:
    """What ``--plugin`` names: the files, which are read, and the classes, which are not imported.

    Raises:
        UsageError: A file is not there or cannot be read, or two have one name.
    """
    classes = tuple(dict.fromkeys(text for text in given if is_class_name(text)))
    files = read_given([text for text in given if text not in classes])
    return tuple(file for file in files if isinstance(file, PluginFile)), classes


Verdict: TypeAlias = Literal["ok", "warning", "error", "not run"]
TARGET = "target"
"""Name of the check that comes before those of the kit: what is registered can be imported, and is of its kind."""
LOADS = "robot-loads"
"""The same of a robot: its files can be read."""


@dataclass(frozen=True)
class Finding:
    """What a check found.

    Attributes:
        check: Its name.
        verdict: How it went.
        sentence: What is wrong, with its numbers; empty where nothing is.
        seconds: What it took.
        story: The traceback behind it; empty where there is none.
        printed: What the plugin printed meanwhile, or the end of that if it is long.
    """

    check: str
    verdict: Verdict
    sentence: str = ""
    seconds: float = 0.0
    story: str = ""
    printed: str = ""


class PlannedCheck(NamedTuple):
    """A check that is to be run.

    Attributes:
        name: Of the check.
        fact: What holds where it is passed.
        seconds: How long it may take.
        long: Whether it takes minutes, and is run on demand.
    """

    name: str
    fact: str
    seconds: float
    long: bool


@dataclass(frozen=True)
class Outline:
    """What is known when the plugin has been imported and built.

    Attributes:
        kind: ``rewards`` and so on; empty if the plugins could not be loaded.
        findings: Of the checks that come before those of the kit.
        checks: What is to be run; nothing if the plugin cannot be checked.
        mistake: The user's, such as an unknown name; empty if there is none.
    """

    kind: str = ""
    findings: tuple[Finding, ...] = ()
    checks: tuple[PlannedCheck, ...] = ()
    mistake: str = ""


def count(findings: Iterable[Finding], verdict: Verdict) -> int:
    """How many findings there are of one verdict."""
    return sum(finding.verdict == verdict for finding in findings)
