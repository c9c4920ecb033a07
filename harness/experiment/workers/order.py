"""Orders for worker processes: the line that a worker reads, and the work that it describes."""

import importlib
import json
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Protocol, Self, TypeAlias

from harness.executor import Limits, Word

Report: TypeAlias = Callable[[Word], None]
"""A function that is told how far the work is."""


class Work(Protocol):
    """Something that a worker can do: a frozen dataclass that says itself in JSON and leaves a folder."""

    noun: ClassVar[str]
    """The name of the work in messages, if its process ends too early."""

    def to_json(self) -> dict[str, Any]:
        """Plain data; `from_json` gives the same work back."""

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """The work that `to_json` told."""

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
        told = {"work": f"{kind.__module__}:{kind.__qualname__}", "content": self.work.to_json()}
        return json.dumps({**told, "folder": str(self.folder), "command": sys.argv})


def read_order(line: str) -> tuple[Order, list[str]]:
    """The order in a line that `Order.line` wrote, and what the user typed."""
    told = json.loads(line)
    module, _, name = told["work"].partition(":")
    kind: type[Work] = getattr(importlib.import_module(module), name)
    return Order(Path(told["folder"]), kind.from_json(told["content"])), told["command"]
