"""What a worker process is told to do for ``harness check``: open what is checked, and run one check of it.

An order leaves a folder with its answer and with what the plugin printed. The plugin's code is not imported before an
order is done, so the process that gives the orders never runs it.
"""

import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, ClassVar, Self

from harness.authoring.checking import print_into
from harness.authoring.commands import Report, partial_folder

from .finding import Asked, Finding, Outline

ANSWER, OUTPUT = "answer.json", "output.txt"
"""Files in an order's folder: the answer, and what the plugin printed. If the process crashed, its stack is there."""


@dataclass(frozen=True)
class TryPlugin:
    """Import and build a plugin, and run one check of it.

    Attributes:
        asked: What is checked.
        notes: Path of a file, see `harness_plugins.kit.inspection.subject.open_subject`.
        check: Name of the check, whose `Finding` is the answer. None: the plugin is only imported and built, and the
            answer is its `Outline`.
    """

    asked: Asked
    notes: str
    check: str | None = None

    noun: ClassVar[str] = "check"

    def to_json(self) -> dict[str, Any]:
        return {"asked": self.asked.to_json(), "notes": self.notes, "check": self.check}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        return cls(Asked.from_json(data["asked"]), data["notes"], data["check"])

    def do(self, folder: Path, report: Report) -> bool:
        partial = partial_folder(folder)
        print_into(partial / OUTPUT)
        (partial / ANSWER).write_text(json.dumps(self._answer()), encoding="utf-8")
        os.rename(partial, folder)  # nobody needs it after a power cut, so the disk is not waited for
        return True

    def _answer(self) -> dict[str, Any]:
        from .subject import open_subject, run_check

        subject = open_subject(self.asked, Path(self.notes))
        return subject.outline.to_json() if self.check is None else asdict(run_check(subject, self.check))


def read_outline(folder: Path) -> Outline | None:
    """The answer of an order without a check; None if it left none."""
    told = _read(folder)
    return None if told is None else Outline.from_json(told)


def read_finding(folder: Path) -> Finding | None:
    """The answer of an order with a check; None if it left none."""
    told = _read(folder)
    return None if told is None else Finding(**told)


def _read(folder: Path) -> dict[str, Any] | None:
    try:
        told: dict[str, Any] = json.loads((folder / ANSWER).read_text(encoding="utf-8"))
    except (OSError, ValueError):  # a plugin may remove what is not its own, or double itself by a fork
        return None
    return told
