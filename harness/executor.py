"""The interface that an executor fills: it gets cells done, wherever it likes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple, Protocol, TypeAlias

from harness.record.cell import Cell


@dataclass(frozen=True)
class CellOptions:
    """How a cell is run; nothing here changes its result.

    Attributes:
        checkpoint_every: Environment steps from one checkpoint of the training to the next, at least; 0 for none, None
            for one every ten minutes. A cell whose process is killed goes on from its last checkpoint.
        tensorboard: Whether the cell leaves event files of scalars too.
    """

    checkpoint_every: int | None = None
    tensorboard: bool = False


class Job(NamedTuple):
    """What to give to `harness.experiment.run_cell.run_cell`."""

    cell: Cell
    folder: Path
    """It has to leave."""
    options: CellOptions = CellOptions()


class Event(NamedTuple):
    """Something that happened to a cell."""

    kind: Literal["started", "progress", "ended"]
    cell: Cell
    steps: int = 0
    reason: str = ""
    """Of an ended cell: why it failed. An executor says it of a cell that left no folder."""
    note: str = ""
    """Of an ended cell: what else there is to say, for who looks on; not for an executor to say."""


OnEvent: TypeAlias = Callable[[Event], None]


class Executor(Protocol):
    """A frozen dataclass whose fields are its settings: ``--executor processes`` or ``--executor mine:nodes=2``."""

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        """Run every job, at most `at_once` at a time.

        `on_event` is called in the caller's thread: ``started``, any number of ``progress``, then ``ended``, once for
        every job. Whatever a cell does, crash and kill included, the others go on. When an exception passes
        (KeyboardInterrupt above all), no cell is left running.
        """
