"""Orders done in fresh Python processes of this machine, several at once, one thread each."""

import json
import os
import queue
import signal
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, Literal, NamedTuple, TypeAlias

from harness.record.folder import partial_folder

# Two one-thread processes train twice as fast as one with two threads.
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
GRACE_SECONDS = 5.0


class Order(NamedTuple):
    """What one process is to do."""

    folder: Path
    """It has to leave; no two orders share one."""
    content: Mapping[str, Any]
    """The rest of the order, JSON-able; see `harness.experiment.worker`."""
    noun: str = "cell"
    """What to call it when its process ends too early."""


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
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))


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
        process = subprocess.Popen(
            [sys.executable, "-m", "harness.experiment.worker"],
            stdin=subprocess.PIPE,  # stays open: a worker ends when its parent is gone
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, **ONE_THREAD},
            start_new_session=True,  # Ctrl-C reaches the parent alone, which stops the workers
        )
        assert process.stdin is not None
        assert process.stdout is not None
        self.running[order.folder] = process
        try:
            text = json.dumps({**order.content, "folder": str(order.folder), "command": sys.argv})
            process.stdin.write(text + "\n")
            process.stdin.flush()
        except BrokenPipeError:
            process.wait()  # died at once: next_news tells
        threading.Thread(target=self._listen, args=(order, process.stdout), daemon=True).start()

    def next_news(self) -> News:
        order, steps = self.told.get()
        if steps is not None:
            return News("progress", order.folder, steps)
        process = self.running.pop(order.folder)
        status = process.wait()
        _close(process)
        complete = not partial_folder(order.folder).exists()
        return News("ended", order.folder, reason="" if complete else _reason(status, order.noun))

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

    def _listen(self, order: Order, lines: IO[str]) -> None:
        """In a thread: each line is the number of steps done; the end of the stream is the end of the order."""
        with lines:
            for line in lines:
                self.told.put((order, int(line)))
        self.told.put((order, None))


def _close(process: "subprocess.Popen[str]") -> None:
    if process.stdin and not process.stdin.closed:
        process.stdin.close()


def _reason(status: int, noun: str) -> str:
    if status < 0:
        return f"its process was ended by {signal.Signals(-status).name}"
    return f"its process ended with exit status {status} before the {noun} did"
