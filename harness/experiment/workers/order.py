"""Orders for worker processes, the work that they describe, and what it tells while it goes on."""

import importlib
import json
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import IO, ClassVar, NamedTuple, Protocol, TypeAlias

from harness.executor import Limits, Word
from harness.files.plain import from_plain, to_plain
from harness.record.progress import TERMS

Report: TypeAlias = Callable[[Word], None]
"""A function that is told how far the work is."""


class Work(Protocol):
    """Something that a worker can do: a frozen dataclass, which travels as JSON and leaves a folder."""

    noun: ClassVar[str]
    """The name of the work in messages, if its process ends too early."""

    def do(self, folder: Path, report: Report) -> bool:
        """Do it, and leave `folder`; returns whether the process may do other work after it."""


class Order(NamedTuple):
    """One thing that a process is to do."""

    folder: Path
    """The folder that the work has to leave. No two orders share a folder."""
    work: Work
    limits: Limits = Limits()
    """How much the order may take. The process that gives the order enforces it."""
    fresh: bool = False
    """Whether the order needs a process that did nothing before."""

    def line(self) -> str:
        """What the worker reads: JSON that names the class of the work, with its content, and what the user typed."""
        kind = type(self.work)
        told = {"work": f"{kind.__module__}:{kind.__qualname__}", "content": to_plain(self.work)}
        return json.dumps({**told, "folder": str(self.folder), "command": sys.argv})


def read_order(line: str) -> tuple[Order, list[str]]:
    """The order in a line that `Order.line` wrote, and what the user typed."""
    told = json.loads(line)
    module, _, name = told["work"].partition(":")
    kind: type[Work] = getattr(importlib.import_module(module), name)
    return Order(Path(told["folder"]), from_plain(kind, told["content"])), told["command"]


def tell(parent: IO[str], word: Word) -> None:
    """Write a line to the process that gave the order."""
    parent.write(f"{word.line()}\n")


TELL_EVERY = 1.0
"""Seconds from one time to tell what was learned to the next."""
SECTION, PAID = "Evaluation", "Cumulative Reward"
"""The first part of each name, and the name of what an episode was paid; both are those of Unity ML-Agents."""


NO_TERMS: Mapping[str, float | None] = MappingProxyType({})


def named_scalars(
    paid: float | None, measures: Mapping[str, float | None], terms: Mapping[str, float | None] = NO_TERMS
) -> dict[str, float]:
    """Numbers by their names for trackers, such as ``Evaluation/Success Rate``. What is None is left out.

    Args:
        paid: Mean over episodes of what the reward of the training paid.
        measures: Means over episodes of what no reward enters, by name, as ``success_rate``.
        terms: Means over episodes of what each term of that reward paid, by name.
    """
    values = {PAID: paid, **{name.replace("_", " ").title(): value for name, value in measures.items()}}
    values |= {f"{TERMS}/{name}": value for name, value in terms.items()}
    return {f"{SECTION}/{name}": float(value) for name, value in values.items() if value is not None}


EVERY = 1.0
"""The least seconds between two reports."""


class Beat:
    """Reports that the work goes on, as often as `EVERY` allows."""

    def __init__(self, report: Report) -> None:
        self._report, self._told = report, time.monotonic()

    def __call__(self, steps: int) -> None:
        """Report that the work goes on, with `steps` of the training done, if a report is due."""
        if time.monotonic() >= self._told + EVERY:
            self._told = time.monotonic()
            self._report(Word(steps))
