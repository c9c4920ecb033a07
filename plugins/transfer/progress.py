"""What one sees while policies are evaluated: a bar on a terminal, and a line for each evaluation that ends."""

import time
from pathlib import Path
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from harness.report.tables.grid import Terminal

from .jobs import TransferEvent, TransferPlan


class TransferProgress:
    """Call it with every event."""

    def __init__(self, plan: TransferPlan, console: Console | None = None) -> None:
        self._console = console or Terminal(stderr=True)
        self._bar = Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            MofNCompleteColumn(),
            TimeRemainingColumn(),
            console=self._console,
        )
        self._total, self._ended = len(plan.jobs), len(plan.jobs) - len(plan.missing)
        self._task = self._bar.add_task("evaluations", total=self._total, completed=self._ended)
        self._started: dict[Path, float] = {}  # titles do not tell cells of other steps or tasks apart
        for line in plan.left_out:
            self._print(line)
        if self._ended:
            self._print(f"{self._ended} of {self._total} evaluations were done before and are not run again")

    def __enter__(self) -> "TransferProgress":
        if self._console.is_terminal and self._ended < self._total:
            self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        if self._bar.live.is_started:  # to stop what never started would print an empty line
            self._bar.stop()

    def __call__(self, event: TransferEvent) -> None:
        """Show an event."""
        job = event.job
        if event.kind == "started":
            self._started[job.folder] = time.perf_counter()
            return
        self._ended += 1
        self._bar.advance(self._task)
        seconds = time.perf_counter() - self._started.pop(job.folder)
        outcome = f"FAILED: {event.reason}" if event.reason else f"{seconds:.1f} s"
        self._print(f"[{self._ended}/{self._total}] {job.title}: {outcome}")

    def _print(self, line: str) -> None:
        self._bar.console.print(line, soft_wrap=True, markup=False, highlight=False)
