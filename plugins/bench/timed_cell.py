"""One cell, timed: in the process that runs it, and around that process."""

import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Self

from harness.authoring.commands import (
    Cell,
    Given,
    News,
    Order,
    Report,
    given_from_json,
    given_to_json,
    read_manifest,
    run_cell,
    run_orders,
)
from harness.executor import CellOptions, Event, OnEvent

from .stopwatch import CLOCK, CellTimes, Stopwatch

FILE = "times.json"
"""In the cell's folder: its times, and what the clock showed when they were told."""


def run_timed(cell: Cell, folder: Path, report: Report, begun: float, plugins: tuple[Given, ...] = ()) -> None:
    """Do what `run_cell` does, and leave the times too.

    Args:
        cell: What to do.
        folder: Of the cell.
        report: Told how far it is.
        begun: What the clock showed before this process was started.
        plugins: Given by hand.
    """
    stopwatch = Stopwatch(begun)
    run_cell(cell, folder, report, CellOptions(plugins=plugins), watch=stopwatch)
    times = stopwatch.stop()
    # Last of all: what follows is the end of the process.
    (folder / FILE).write_text(json.dumps({"times": asdict(times), "told": begun + times.whole}))


@dataclass(frozen=True)
class TimeCell:
    """`run_timed`, as a worker is told to do it.

    Attributes:
        cell: What to do.
        begun: What the clock showed before the worker was started.
        plugins: Given by hand.
    """

    cell: Cell
    begun: float
    plugins: tuple[Given, ...] = ()

    noun: ClassVar[str] = "cell"

    def to_json(self) -> dict[str, Any]:
        return {"cell": self.cell.to_json(), "begun": self.begun, "plugins": given_to_json(self.plugins)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        return cls(Cell.from_json(data["cell"]), data["begun"], given_from_json(data["plugins"]))

    def do(self, folder: Path, report: Report) -> bool:
        run_timed(self.cell, folder, report, self.begun, self.plugins)
        return False  # the end of the process is timed too


class Failed(NamedTuple):
    """Why a cell has no times: it raised, or its process ended early."""

    reason: str


def time_cell(cell: Cell, folder: Path, on_event: OnEvent, plugins: Sequence[Given] = ()) -> CellTimes | Failed:
    """Have a fresh one-thread process run a cell, as ``harness run`` does.

    Args:
        cell: What to do.
        folder: Where; removed again.
        on_event: Told what happens to the cell.
        plugins: Given by hand.
    """
    ended: list[tuple[float, str]] = []

    def tell(news: News) -> None:
        reason, now = news.reason, CLOCK()
        if news.kind == "ended":
            reason = reason or _reason(folder)
            ended.append((now, reason))
        on_event(Event(news.kind, cell, news.steps, reason, scalars=news.scalars))

    run_orders([Order(folder, TimeCell(cell, CLOCK(), tuple(plugins)), fresh=True)], 1, tell)
    [(end, reason)] = ended
    if reason:
        return Failed(reason)
    data = json.loads((folder / FILE).read_text())
    shutil.rmtree(folder)
    return CellTimes(**data["times"]).ended_after(end - data["told"])


def _reason(folder: Path) -> str:
    """Why a cell that left its folder has no times; empty if it has."""
    reason = read_manifest(folder).reason
    return reason if reason or (folder / FILE).exists() else "its process ended before it told its times"
