"""What one sees while cells run: a bar per running cell, with steps per second and the time left."""

import time
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TaskID, TextColumn, TimeRemainingColumn
from rich.table import Column
from rich.text import Text

from harness.cli.terminal import Terminal
from harness.executor import Event
from harness.record.cell import Cell


class LiveProgress:
    """Call it with every event. Without a terminal it prints a line when a cell starts or ends."""

    def __init__(
        self,
        cells: Sequence[Cell],
        done: Collection[Cell],
        console: Console | None = None,
        log_of: Callable[[Cell], Path] | None = None,
    ) -> None:
        """Show nothing yet.

        Args:
            cells: All cells of the experiment that are asked for.
            done: Those of them that were done before.
            console: Where to show it.
            log_of: Where the log of a cell that failed is; None where there is none to look at.
        """
        self._log_of = log_of
        self._console = console or Terminal(stderr=True)
        self._progress = Progress(
            TextColumn("{task.description}", markup=False, table_column=Column(ratio=1, no_wrap=True)),
            BarColumn(bar_width=8),
            StepSpeed(table_column=Column(no_wrap=True, justify="right")),
            TimeRemainingColumn(),
            console=self._console,
            expand=True,  # a cell has one line: what is too long for it is its name, at 60 columns
        )
        ended = {cell.id for cell in done}
        steps = sum(cell.steps for cell in cells if cell.id not in ended)
        self._overall = self._progress.add_task("all cells", total=steps)
        self._tasks: dict[str, TaskID] = {}
        self._steps: dict[str, int] = {}
        self._started: dict[str, float] = {}
        self._total, self._ended = len(cells), len(done)
        self._failed: set[str] = set()
        if done:
            self._console.print(f"{len(done)} of {len(cells)} cells were done before and are not run again")

    def __enter__(self) -> "LiveProgress":
        if self._console.is_terminal and self._ended < self._total:
            self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        if self._progress.live.is_started:  # to stop what never started would print an empty line
            self._progress.stop()

    def __call__(self, event: Event) -> None:
        """Show an event."""
        show = {"started": self._start, "progress": self._advance, "ended": self._end}
        show[event.kind](event)

    def _start(self, event: Event) -> None:
        cell = event.cell
        if cell.id in self._failed:  # it is tried again
            self._failed.remove(cell.id)
            self._ended -= 1
        self._started[cell.id], self._steps[cell.id] = time.perf_counter(), 0
        self._tasks[cell.id] = self._progress.add_task(cell.title, total=cell.steps)
        if not self._console.is_terminal:
            self._print(f"{cell.title}: started")

    def _advance(self, event: Event) -> None:
        cell = event.cell
        self._progress.update(self._tasks[cell.id], completed=event.steps)
        self._progress.advance(self._overall, event.steps - self._steps[cell.id])
        self._steps[cell.id] = event.steps

    def _end(self, event: Event) -> None:
        cell = event.cell
        self._ended += 1
        self._progress.remove_task(self._tasks.pop(cell.id))
        self._progress.advance(self._overall, cell.steps - self._steps.pop(cell.id))  # a failed cell is over too
        seconds = time.perf_counter() - self._started.pop(cell.id)
        outcome = self._failure(event) if event.reason else f"{seconds:.0f} s, {cell.steps / seconds:.0f} steps/s"
        note = f" ({event.note})" if event.note else ""
        self._print(f"[{self._ended}/{self._total}] {cell.title}: {outcome}{note}")

    def _failure(self, event: Event) -> str:
        self._failed.add(event.cell.id)
        log = f" Log: {self._log_of(event.cell)}" if self._log_of else ""
        return f"FAILED: {event.reason}.{log}"

    def _print(self, line: str) -> None:
        self._progress.console.print(line, soft_wrap=True, markup=False, highlight=False)


class StepSpeed(ProgressColumn):
    """Steps done and steps per second."""

    def render(self, task: Task) -> Text:
        """As ``4200/10000 · 155/s``."""
        speed = f"{task.speed:.0f}/s" if task.speed else "starting"
        return Text(f"{task.completed:.0f}/{task.total:.0f} · {speed}")
