"""The interface that an executor fills: it gets cells done, wherever it likes."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, NamedTuple, Protocol, Self, TypeAlias

from harness.record.cell import Cell
from harness.registry.given import Given, given_from_json

NO_SCALARS: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True)
class Limits:
    """What a cell may take before its process is ended and the cell counts as failed; 0 for no limit.

    Attributes:
        stall_after: Seconds without a word of progress, in the training and in the evaluation after it.
        cell_time: Seconds in all.
        cell_memory: GiB in memory, of the cell's process and of those that it started.
    """

    stall_after: float = 0.0
    cell_time: float = 0.0
    cell_memory: float = 0.0


@dataclass(frozen=True)
class CellOptions:
    """How a cell is run; nothing here changes its result.

    Attributes:
        checkpoint_every: Environment steps from one checkpoint of the training to the next, at least; 0 for none, None
            for one every ten minutes. A cell whose process is killed goes on from its last checkpoint.
        tracked: Whether somebody wants to hear what the algorithm and each evaluation tell; see `Word.scalars`.
        limits: What the cell may take.
        fresh: Whether the cell gets a process of its own, which did no other cell before.
        floor: Whether the cell evaluates random actions too. What they do depends on simulator, task and robot alone:
            one cell of an experiment that has these does it for all.
        plugins: What was given by hand beside the installed plugins: files with their text, and names of classes.
    """

    checkpoint_every: int | None = None
    tracked: bool = False
    limits: Limits = Limits()
    fresh: bool = False
    floor: bool = True
    plugins: tuple[Given, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Plain data; `from_json` gives the same options back."""
        return asdict(self)

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """The options that `to_json` told."""
        plugins = given_from_json(data.get("plugins", ()))
        return cls(**{**data, "limits": Limits(**data["limits"]), "plugins": plugins})


class Job(NamedTuple):
    """What to give to `harness.experiment.run_cell.run_cell`."""

    cell: Cell
    folder: Path
    """It has to leave."""
    options: CellOptions = CellOptions()

    def to_json(self) -> dict[str, Any]:
        """Plain data; `from_json` gives the same job back."""
        return {"cell": self.cell.to_json(), "folder": str(self.folder), "options": self.options.to_json()}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> "Job":
        """The job that `to_json` told."""
        return cls(Cell.from_json(data["cell"]), Path(data["folder"]), CellOptions.from_json(data["options"]))


class Word(NamedTuple):
    """What a cell tells while it is done.

    Attributes:
        steps: Environment steps done so far.
        scalars: Numbers to watch, by name; those that `harness.progress` names come about once a second.
    """

    steps: int
    scalars: Mapping[str, float] = NO_SCALARS

    def line(self) -> str:
        """One line: the steps, and behind them the numbers as JSON, if there are any; `from_line` reads it."""
        return f"{self.steps} {json.dumps(dict(self.scalars))}" if self.scalars else f"{self.steps}"

    @classmethod
    def from_line(cls, line: str) -> Self:
        """The word that `line` wrote."""
        steps, _, scalars = line.partition(" ")
        return cls(int(steps), json.loads(scalars) if scalars else NO_SCALARS)


class Event(NamedTuple):
    """Something that happened to a cell."""

    kind: Literal["started", "progress", "ended"]
    cell: Cell
    steps: int = 0
    reason: str = ""
    """Of an ended cell: why it failed. An executor says it of a cell that left no folder."""
    note: str = ""
    """Of an ended cell: what else there is to say, for who looks on; not for an executor to say."""
    scalars: Mapping[str, float] = NO_SCALARS
    """Of progress: the numbers of a `Word`. An executor may leave out words without numbers; the others it hands on."""


OnEvent: TypeAlias = Callable[[Event], None]


class Executor(Protocol):
    """A frozen dataclass whose fields are its settings: ``--executor processes`` or ``--executor mine:nodes=2``."""

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        """Run every job, at most `at_once` at a time.

        `on_event` is called in the caller's thread: ``started``, any number of ``progress``, then ``ended``, once for
        every job. Whatever a cell does, crash and kill included, the others go on. When an exception passes
        (KeyboardInterrupt above all), no cell is left running. `harness.experiment.jobs` has what to build with, and
        `harness.testing.check_executor` tries all of this.
        """
