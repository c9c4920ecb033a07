"""What the trial of a task found."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from traceback import extract_tb
from typing import Any, Literal, Self, TypeAlias

import harness
from harness.errors import one_line
from harness.record.recording.facts import FILE_BEHAVIOUR, FILE_REWARD

Noun: TypeAlias = Literal["reward", "measure"]


@dataclass(frozen=True)
class Fault:
    """A reward or a measure that cannot be used.

    Attributes:
        noun: What it is.
        name: What users call it.
        reason: What it did, a sentence to follow on its name: ``fails in step 0: ZeroDivisionError: division by zero.``
        is_lost: Whether the process did not survive it: whatever asks it is lost, not it alone.
    """

    noun: Noun
    name: str
    reason: str
    is_lost: bool = False

    @property
    def column(self) -> str:
        """Its name among columns, ``reward_calm``; `fault_of` takes it."""
        return f"{FILE_REWARD if self.noun == 'reward' else FILE_BEHAVIOUR}{self.name}"

    @property
    def sentence(self) -> str:
        """All of that."""
        return f"{self.noun} '{self.name}' {self.reason}"


@dataclass(frozen=True)
class Tried:
    """What the trial of one task, or of one environment, found.

    Attributes:
        faults: What cannot be used.
        notes: What else there is to know, a line each.
    """

    faults: tuple[Fault, ...] = ()
    notes: tuple[str, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Plain data; `from_json` gives the same back."""
        return asdict(self)

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """What `to_json` told."""
        return cls(tuple(Fault(**fault) for fault in data["faults"]), tuple(data["notes"]))


def fault_of(column: str, reason: str, *, is_lost: bool = False) -> Fault:
    """The fault of a column, ``reward_calm`` or ``behaviour_height``."""
    noun: Noun = "reward" if column.startswith(FILE_REWARD) else "measure"
    return Fault(noun, column.removeprefix(FILE_REWARD if noun == "reward" else FILE_BEHAVIOUR), reason, is_lost)


def error_text(error: BaseException) -> str:
    """What a plugin raised, and where in its file."""
    own = [
        it for it in extract_tb(error.__traceback__) if Path(harness.__file__).parent not in Path(it.filename).parents
    ]
    return f"{one_line(error)} ({Path(own[-1].filename).name}, line {own[-1].lineno})" if own else one_line(error)
