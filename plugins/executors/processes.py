"""Runs every cell in a fresh Python process, several at once."""

from collections.abc import Sequence
from dataclasses import dataclass

from harness.executor import Event, Job, OnEvent
from harness.experiment.order import Order
from harness.experiment.run_cell import TrainCell
from harness.experiment.workers import News, run_orders


@dataclass(frozen=True)
class Processes:
    """Cells in processes of this machine, one thread each."""

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        """See `harness.executor.Executor`."""
        cells = {job.folder: job.cell for job in jobs}

        def tell(news: News) -> None:
            on_event(Event(news.kind, cells[news.folder], news.steps, news.reason))

        run_orders([Order(job.folder, TrainCell(job.cell, job.options)) for job in jobs], at_once, tell)
