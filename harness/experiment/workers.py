"""Orders done in fresh Python processes of this machine, several at once, one thread each."""

import os
import queue
import signal
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Literal, NamedTuple, TypeAlias

from harness.errors import UsageError
from harness.experiment.order import Order
from harness.record.folder import partial_folder

# Two one-thread processes train twice as fast as one with two threads.
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
GRACE_SECONDS = 5.0


class News(NamedTuple):
    """Something that happened to an order."""

    kind: Literal["started", "progress", "ended"]
    folder: Path
    """Of the order."""
    steps: int = 0
    reason: str = ""
    """Of an ended order: why its process left no folder; empty if it did."""


OnNews: TypeAlias = Callable[[News], None]


def core_count() -> int:
    """Cores that this process may use; where the system does not say, as on macOS and Windows, those of the machine."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def worker_count(jobs: int | None) -> int:
    """How many workers there are at once: as many as asked for, by default as many as there are cores.

    Raises:
        UsageError: Fewer than one is asked for.
    """
    if jobs is not None and jobs < 1:
        raise UsageError(f"jobs={jobs}: must be at least 1")
    return jobs or core_count()


def run_orders(orders: Sequence[Order], at_once: int, on_news: OnNews) -> None:
    """Have every order done by a process of its own, at most `at_once` at a time.

    Whatever a process does, crash and kill included, the others go on. When an exception passes, KeyboardInterrupt
    above all, none is left running.

    Args:
        orders: What to do, in this order.
        at_once: How many processes.
        on_news: Called in this thread: ``started``, any number of ``progress``, then ``ended``, once for every order.
    """
    waiting, workers = deque(orders), _Workers()
    try:
        while waiting or workers.running:
            while waiting and len(workers.running) < at_once:
                order = waiting.popleft()
                workers.start(order)
                on_news(News("started", order.folder))
            on_news(workers.next_news())
    finally:
        workers.stop()


@dataclass
class _Workers:
    """The running processes, and one queue of what they tell."""

    running: dict[Path, "subprocess.Popen[str]"] = field(default_factory=dict)
    told: "queue.SimpleQueue[tuple[Order, int | None]]" = field(default_factory=queue.SimpleQueue)

    def start(self, order: Order) -> None:
        partial_folder(order.folder).mkdir(parents=True, exist_ok=True)  # gone again when the order is done
        process = start_process("harness.experiment.worker", order.line(), stdout=subprocess.PIPE)
        assert process.stdout is not None
        self.running[order.folder] = process
        threading.Thread(target=self._listen, args=(order, process.stdout), daemon=True).start()

    def next_news(self) -> News:
        order, steps = self.told.get()
        if steps is not None:
            return News("progress", order.folder, steps)
        process = self.running.pop(order.folder)
        status = process.wait()
        _close(process)
        complete = not partial_folder(order.folder).exists()
        return News("ended", order.folder, reason="" if complete else _reason(status, order.work.noun))

    def stop(self) -> None:
        stop_processes(self.running.values())
        self.running.clear()

    def _listen(self, order: Order, lines: IO[str]) -> None:
        """In a thread: each line is the number of steps done; the end of the stream is the end of the order."""
        with lines:
            for line in lines:
                self.told.put((order, int(line)))
        self.told.put((order, None))


def start_process(
    module: str, line: str, stdout: IO[str] | int, stderr: IO[str] | int | None = None
) -> "subprocess.Popen[str]":
    """Start a Python module in a process of its own, with one thread, and write `line` to its standard input.

    The standard input stays open: the process ends when this one does (`harness.experiment.lifeline`).
    """
    process = subprocess.Popen(
        [sys.executable, "-m", module],
        stdin=subprocess.PIPE,
        text=True,
        env={**os.environ, **ONE_THREAD},
        start_new_session=True,  # Ctrl-C reaches this process alone, which stops the others
        stdout=stdout,
        stderr=stderr,
    )
    assert process.stdin is not None
    try:
        process.stdin.write(line + "\n")
        process.stdin.flush()
    except BrokenPipeError:
        process.wait()  # died at once: its status tells
    return process


def stop_processes(processes: Collection["subprocess.Popen[str]"]) -> None:
    """Ask the processes that still run to end, and end those that do not."""
    running = [process for process in processes if process.poll() is None]
    for process in running:
        process.terminate()
    for process in running:
        try:
            process.wait(GRACE_SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
    for process in processes:
        _close(process)


def _close(process: "subprocess.Popen[str]") -> None:
    if process.stdin and not process.stdin.closed:
        process.stdin.close()


def _reason(status: int, noun: str) -> str:
    if status < 0:
        return f"its process was ended by {signal.Signals(-status).name}"
    return f"its process ended with exit status {status} before the {noun} did"
