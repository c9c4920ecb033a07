"""Runs every cell in a fresh Python process, several at once."""

import json
import os
import queue
import signal
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import IO

from harness.cell_folder import partial_folder
from harness.executor import Event, Job, OnEvent

# Two one-thread processes train twice as fast as one with two threads.
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
GRACE_SECONDS = 5.0


@dataclass(frozen=True)
class Processes:
    """Cells in processes of this machine, one thread each."""

    def run(self, jobs: Sequence[Job], at_once: int, on_event: OnEvent) -> None:
        """See `harness.executor.Executor`."""
        waiting, workers = deque(jobs), _Workers()
        try:
            while waiting or workers.running:
                while waiting and len(workers.running) < at_once:
                    job = waiting.popleft()
                    workers.start(job)
                    on_event(Event("started", job.cell))
                on_event(workers.next_event())
        finally:
            workers.stop()


@dataclass
class _Workers:
    """The running processes, and one queue of what they tell."""

    running: dict[str, "subprocess.Popen[str]"] = field(default_factory=dict)
    events: "queue.SimpleQueue[tuple[Job, int | None]]" = field(default_factory=queue.SimpleQueue)

    def start(self, job: Job) -> None:
        partial_folder(job.folder).mkdir(parents=True, exist_ok=True)  # gone again when the cell is complete
        process = subprocess.Popen(
            [sys.executable, "-m", "harness.worker"],
            stdin=subprocess.PIPE,  # stays open: a worker ends when its parent is gone
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, **ONE_THREAD},
            start_new_session=True,  # Ctrl-C reaches the parent alone, which stops the workers
        )
        assert process.stdin is not None
        assert process.stdout is not None
        order = {"cell": job.cell.to_json(), "folder": str(job.folder), "command": sys.argv}
        self.running[job.cell.id] = process
        try:
            process.stdin.write(json.dumps(order) + "\n")
            process.stdin.flush()
        except BrokenPipeError:
            process.wait()  # died at once: next_event tells
        threading.Thread(target=self._listen, args=(job, process.stdout), daemon=True).start()

    def next_event(self) -> Event:
        job, steps = self.events.get()
        if steps is not None:
            return Event("progress", job.cell, steps)
        process = self.running.pop(job.cell.id)
        status = process.wait()
        _close(process)
        complete = not partial_folder(job.folder).exists()
        return Event("ended", job.cell, reason="" if complete else _reason(status))

    def stop(self) -> None:
        for process in self.running.values():
            process.terminate()
        for process in self.running.values():
            try:
                process.wait(GRACE_SECONDS)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            _close(process)
        self.running.clear()

    def _listen(self, job: Job, lines: IO[str]) -> None:
        """In a thread: each line is the number of steps done; the end of the stream is the end of the cell."""
        with lines:
            for line in lines:
                self.events.put((job, int(line)))
        self.events.put((job, None))


def _close(process: "subprocess.Popen[str]") -> None:
    if process.stdin and not process.stdin.closed:
        process.stdin.close()


def _reason(status: int) -> str:
    if status < 0:
        return f"its process was ended by {signal.Signals(-status).name}"
    return f"its process ended with exit status {status} before the cell did"
