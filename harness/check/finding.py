"""What a check found, and what is known of the checks before they are run."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal, NamedTuple, Self, TypeAlias

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

    def to_json(self) -> dict[str, Any]:
        """Plain data; `from_json` gives the same back."""
        return asdict(self)

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """What `to_json` told."""
        findings = tuple(Finding(**finding) for finding in data["findings"])
        checks = tuple(PlannedCheck(*check) for check in data["checks"])
        return cls(data["kind"], findings, checks, data["mistake"])


def count(findings: Iterable[Finding], verdict: Verdict) -> int:
    """How many findings there are of one verdict."""
    return sum(finding.verdict == verdict for finding in findings)
