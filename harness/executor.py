"""What happens around cells: executors get them done, trackers show them elsewhere, screens look at rewards before."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol, Self, TypeAlias

from harness.face import face_of
from harness.files.plain import Plain
from harness.record.cell import Cell as Cell
from harness.registry.given import Given

if TYPE_CHECKING:
    from harness.authoring.folder_parts import Part as Part, add_parts as add_parts, parts_of as parts_of
    from harness.experiment.jobs import run_job as run_job, run_jobs as run_jobs
    from harness.experiment.screening import Screen as Screen, Screened as Screened
else:
    __all__, __getattr__ = face_of(
        __name__,
        "Event", "Executor", "Job", "OnEvent", "Outcome", "Track", "TrackedCell", "Tracker", "Word",
    )  # fmt: skip

NO_SCALARS: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True)
class Limits:
    """What a cell may take before its process is ended and the cell counts as failed; 0 for no limit.

    Attributes:
        stall_after: Seconds without a report of progress, in the training and in the evaluation after it.
        cell_time: Seconds in all.
        cell_memory: GiB of memory of the cell's process and of the processes that it started, together.
    """

    stall_after: float = 0.0
    cell_time: float = 0.0
    cell_memory: float = 0.0


@dataclass(frozen=True)
class CellOptions:
    """How a cell is run; nothing here changes its result.

    Attributes:
        checkpoint_every: Environment steps from one checkpoint of the training to the next, at least. 0: no
            checkpoints. None: one every ten minutes. A cell whose process is killed goes on from its last checkpoint.
        tracked: Whether a tracker needs the numbers of the algorithm and of each evaluation; see `Word.scalars`.
        limits: How much time and memory the cell may take.
        fresh: Whether the cell gets a process of its own, which did no other cell before.
        floor: Whether the cell evaluates random actions too. The result depends only on simulator, task and robot, so
            one cell of an experiment does it for all cells that share these three.
        plugins: The plugins that were given by hand: files with their text, and names of classes.
    """

    checkpoint_every: int | None = None
    tracked: bool = False
    limits: Limits = Limits()
    fresh: bool = False
    floor: bool = True
    plugins: tuple[Given, ...] = ()


@dataclass(frozen=True)
class Job(Plain):
    """What to give to `harness.experiment.run_cell.run_cell`."""

    cell: Cell
    folder: Path
    """The folder that the job has to leave."""
    options: CellOptions = CellOptions()


class Word(NamedTuple):
    """A report of progress from a running cell.

    Attributes:
        steps: Environment steps done so far.
        scalars: Numbers to watch, by name; those that `harness.record.progress` names come about once a second.
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
    """Why an ended cell failed. An executor sets it only for a cell that left no folder."""
    note: str = ""
    """A remark on an ended cell, shown to the user. The harness sets it; an executor does not."""
    scalars: Mapping[str, float] = NO_SCALARS
    """The numbers of a `Word`, with progress. An executor has to pass on every word that has numbers, and may leave out
    the others."""


OnEvent: TypeAlias = Callable[[Event], None]


class Executor(Protocol):
    """A frozen dataclass whose fields are its settings: ``--executor processes`` or ``--executor mine:nodes=2``."""

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        """Run every job, at most `at_once` at a time.

        For every job it calls `on_event` in the caller's thread: once with ``started``, any number of times with
        ``progress``, and once with ``ended``. If a cell crashes or is killed, the others go on. If an exception ends
        this method (above all KeyboardInterrupt), no cell is left running. `harness.experiment.jobs` has building
        blocks.
        """


Outcome: TypeAlias = Literal["done", "failed", "interrupted"]


@dataclass(frozen=True)
class TrackedCell:
    """What a tracker gets to know about a cell.

    Attributes:
        id: At most 28 digits, letters and ``-``. No other cell has this id. A cell that is done again from the start
            gets a new id. A cell that goes on from a checkpoint after its run was killed keeps its id.
        title: A name for people: the combination and the seed.
        group: A name for people: the combination. All seeds of a combination share it.
        config: Every parameter of the cell by name, such as ``reward.k1``; text, numbers, bool, None and lists of them.
        folder: The experiment's folder. A tracker may make a folder of its own name in it.
    """

    id: str
    title: str
    group: str
    config: Mapping[str, Any]
    folder: Path


class Track(Protocol):
    """What a tracker keeps of one cell."""

    def log(self, steps: int, scalars: Mapping[str, float]) -> None:
        """Numbers by name, such as ``Training/Success Rate``, as they are after `steps` environment steps.

        `steps` never becomes smaller, except in the last calls of an evaluation. Several calls may have the same
        `steps`, with other names. Numbers may be NaN or infinite.
        """

    def end(self, outcome: Outcome, reason: str) -> None:
        """The cell has ended. If it failed, `reason` says why. `log` is not called afterwards."""


class Tracker(Protocol):
    """A frozen dataclass whose fields are its settings: ``--tracker wandb:project=arms,mode=offline``.

    All calls except `why_not` come from one thread. It is not the thread that runs the experiment, so a tracker may
    wait for a server. A tracker that raises an exception is not called again, and the cells go on.
    """

    def why_not(self) -> str:
        """Why it cannot be used now, and what to do about it; empty if it can. Writes nothing, calls no server."""

    def begin(self, cell: TrackedCell) -> Track:
        """A cell begins, or it goes on. If it goes on, another process has called `begin` with the same `cell.id`.

        Several cells are tracked at once. If a cell goes on, what was logged before is not logged again.
        """
