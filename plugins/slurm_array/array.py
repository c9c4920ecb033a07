"""Cells as jobs of a cluster: submitted, followed, cancelled."""

import sys
import time
import types
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from harness.executor import Event, Job, OnEvent
from harness.record.cell import write_log
from harness.record.folder import LOG, partial_folder

from .cluster import Cluster, SubmittedJob
from .task import CellTask, Told

READ_EVERY: Final = 0.5
"""Seconds between two looks at the reports of the jobs."""
ASK_EVERY: Final = 10.0
"""Seconds between two questions to the cluster, because many users ask it."""


@dataclass(eq=False)
class _Submitted:
    """A cell whose job was submitted to the cluster.

    Attributes:
        job: What to do.
        handle: submitit's handle of the cluster's job.
        told: The reports of the cluster's job.
        has_begun: Whether that job has reported that it began.
        is_over: Whether the cluster has said that it does not run any more.
    """

    job: Job
    handle: SubmittedJob
    told: Told
    has_begun: bool = False
    is_over: bool = False


class Array:
    """Does jobs on a cluster."""

    def __init__(self, jobs: Sequence[Job], cluster: Cluster, on_event: OnEvent) -> None:
        self._waiting, self._cluster, self._on_event = deque(jobs), cluster, on_event
        self._submitted: list[_Submitted] = []
        self._asked = time.monotonic()

    def run(self) -> None:
        """Do all jobs. If this is interrupted, the jobs that were submitted are cancelled."""
        try:
            while self._waiting or self._submitted:
                self._submit()
                for cell in list(self._submitted):
                    self._read(cell)
                if time.monotonic() - self._asked >= ASK_EVERY:
                    self._ask()
                time.sleep(READ_EVERY)
        finally:
            self._cluster.cancel([cell.handle for cell in self._submitted])

    def _submit(self) -> None:
        room = min(self._cluster.room(len(self._submitted)), len(self._waiting))
        if room <= 0:
            return
        jobs = [self._waiting.popleft() for _ in range(room)]
        files = [self._cluster.folder / f"{job.folder.name}.jsonl" for job in jobs]
        tasks = [CellTask(job.to_json(), tuple(sys.argv), file) for job, file in zip(jobs, files, strict=True)]
        handles = self._cluster.submit(tasks)
        for job, handle, file in zip(jobs, handles, files, strict=True):
            self._submitted.append(_Submitted(job, handle, Told(file)))

    def _read(self, cell: _Submitted) -> None:
        for kind, steps, reason, scalars in cell.told.news():
            self._tell(cell, kind, steps, reason, scalars)

    def _tell(
        self,
        cell: _Submitted,
        kind: Any,
        steps: int = 0,
        reason: str = "",
        scalars: Mapping[str, float] = types.MappingProxyType({}),
    ) -> None:
        if kind == "started" and cell.has_begun:
            return  # it was queued again
        cell.has_begun = True
        if kind == "ended":
            self._submitted.remove(cell)
        self._on_event(Event(kind, cell.job.cell, steps, reason, scalars=scalars))

    def _ask(self) -> None:
        """Ask the cluster which jobs are over. A job that is over in two answers and reported no end is lost."""
        self._asked = time.monotonic()
        over = self._cluster.over([cell.handle for cell in self._submitted])
        for cell in list(self._submitted):
            state = over.get(cell.handle.job_id)
            if state and cell.is_over:
                self._lose(cell, state)
            cell.is_over = state is not None

    def _lose(self, cell: _Submitted, state: str) -> None:
        partial = partial_folder(cell.job.folder)
        partial.mkdir(parents=True, exist_ok=True)
        write_log(partial / LOG, f"job {cell.handle.job_id} is {state}; it said: {cell.handle.stderr() or 'nothing'}")
        if not cell.has_begun:
            self._tell(cell, "started")
        self._tell(cell, "ended", reason=f"its job {cell.handle.job_id} is {state}")
