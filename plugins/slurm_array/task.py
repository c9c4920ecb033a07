"""What a job of the cluster does, and the file into which it reports what happens."""

import json
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from submitit.helpers import DelayedSubmission

from harness.executor import Event, Job, run_jobs

TELL_EVERY: Final = 1.0
"""Seconds between two reports of progress."""


@dataclass(frozen=True)
class CellTask:
    """Does a cell in a process of its own, and reports what happens.

    Attributes:
        job: The job, by `Job.to_json`.
        command: What the user typed.
        told: The file of the reports, with a line of JSON per event.
    """

    job: dict[str, Any]
    command: tuple[str, ...]
    told: Path

    def __call__(self) -> None:
        """Do the cell."""
        sys.argv = list(self.command)  # the manifest records it
        last = 0.0

        def tell(event: Event) -> None:
            nonlocal last
            if event.kind != "progress" or event.scalars or time.monotonic() - last >= TELL_EVERY:
                last = time.monotonic()
                with self.told.open("a") as file:  # closed again, so that another machine sees it
                    file.write(json.dumps([event.kind, event.steps, event.reason, dict(event.scalars)]) + "\n")

        run_jobs([Job.from_json(self.job)], 1, tell)

    def checkpoint(self) -> DelayedSubmission:
        """Queue the job again when its time is up or it has to make room for another job.

        The library submitit calls this. The cell goes on from its checkpoint.
        """
        return DelayedSubmission(self)


@dataclass
class Told:
    """Reads the reports of a job while their file grows.

    Attributes:
        path: The file of the reports.
    """

    path: Path
    _read: int = field(default=0, init=False)

    def news(self) -> list[tuple[Any, int, str, dict[str, float]]]:
        """Kind, steps, reason and scalars of each event since the last call. Half a line is left for a later call."""
        if not self.path.exists():
            return []
        with self.path.open("rb") as file:
            file.seek(self._read)
            whole, newline, _ = file.read().rpartition(b"\n")
        self._read += len(whole + newline)
        return [tuple(event) for event in map(json.loads, whole.splitlines())]
