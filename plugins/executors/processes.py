"""Runs every cell in a Python process of this machine, several at once."""

from collections.abc import Sequence
from dataclasses import dataclass

from harness.executor import Job, OnEvent, run_jobs


@dataclass(frozen=True)
class Processes:
    """Runs cells in processes of this machine, with one thread each. A process does one cell after the other."""

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        run_jobs(jobs, at_once, on_event)
