"""One Python process that works for this one, and how it is ended."""

import os
import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import IO, Final, TypeAlias

from harness.executor import Limits
from harness.experiment.workers.order import Order

LOOK_EVERY: Final = 0.5
"""Seconds between two looks at the workers."""
LONGEST_LOOK: Final = 5.0
"""The most seconds that count between two looks, so that a machine that slept is not taken for a cell that hangs."""
GIB: Final = 2**30


class Clock:
    """Seconds that this process was awake and looked."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now, self._last, self.seconds = now, now(), 0.0

    def look(self) -> float:
        """The time, with what has passed since the last look."""
        now = self._now()
        self.seconds += min(now - self._last, LONGEST_LOOK)
        self._last = now
        return self.seconds


@dataclass
class Watchdog:
    """The state of an order that is being done.

    Attributes:
        limits: What it may take.
        clock: Of the process that watches.
    """

    limits: Limits
    clock: Clock
    _started: float = field(init=False)
    _heard: float = field(init=False)

    def __post_init__(self) -> None:
        """Begin to watch the order."""
        self._started = self._heard = self.clock.seconds

    def hear(self) -> None:
        """Note that there is news of the order."""
        self._heard = self.clock.seconds

    def complaint(self, memory: Callable[[], int]) -> str:
        """Why the order has to be ended; empty if it may go on.

        Args:
            memory: Tells the bytes that its process has in memory; asked only if there is a limit.
        """
        now, limits = self.clock.seconds, self.limits
        if limits.stall_after and now - self._heard >= limits.stall_after:
            return f"no progress for {limits.stall_after:g} s (--stall-after)"
        if limits.cell_time and now - self._started >= limits.cell_time:
            return f"it took longer than the {limits.cell_time:g} s that --cell-time allows"
        if limits.cell_memory and (used := memory()) > limits.cell_memory * GIB:
            return f"it used {used / GIB:.2f} GiB of memory, --cell-memory allows {limits.cell_memory:g}"
        return ""


# Two one-thread processes train twice as fast as one with two threads.
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
GRACE_SECONDS = 5.0
"""Seconds that a process gets to end before it is killed."""
LEAVING_SECONDS = 10.0
"""Seconds that a process gets which has nothing more to do. A thread or an exit handler of a plugin may never end."""

Told: TypeAlias = tuple["WorkerProcess", str | None]
"""The process that reports, and its line; None at the end of its output."""


class WorkerProcess:
    """``python -m harness.experiment.workers.worker``; each line of its output goes into a queue.

    Attributes:
        process: The process.
        given: Orders that it got.
    """

    def __init__(self, told: "queue.SimpleQueue[Told]", environment: Mapping[str, str]) -> None:
        """Start it.

        Args:
            told: Gets its lines.
            environment: Variables that it has beside those of this process.
        """
        self.process = _start(environment)
        self.given = 0
        assert self.process.stdout is not None
        threading.Thread(target=self._listen, args=(self.process.stdout, told), daemon=True).start()

    def give(self, order: Order) -> None:
        """Give the process an order. If it cannot read the order, it ends."""
        self.given += 1
        assert self.process.stdin is not None
        try:
            self.process.stdin.write(order.line() + "\n")
            self.process.stdin.flush()
        except BrokenPipeError:
            self.process.wait()

    def memory(self) -> int:
        """Bytes that it and the processes that it started have in memory; 0 when it has ended."""
        import psutil  # where a limit was asked for

        try:
            process = psutil.Process(self.process.pid)
            return sum(one.memory_info().rss for one in (process, *process.children(recursive=True)))
        except psutil.NoSuchProcess:
            return 0

    def abort(self) -> None:
        """End it so that it writes its stack into its log (`faulthandler`); kill it if that takes too long."""
        self.process.send_signal(signal.SIGABRT if os.name == "posix" else signal.SIGTERM)
        killer = threading.Timer(GRACE_SECONDS, self.process.kill)
        killer.daemon = True
        killer.start()

    def close(self) -> None:
        """Say that there is nothing more to do; it ends by itself."""
        _close(self.process)

    def end(self) -> int:
        """Wait for it to end, as it does after the last word of its output; returns its exit status.

        If it takes longer than `LEAVING_SECONDS`, it is killed.
        """
        self.close()
        try:
            return self.process.wait(LEAVING_SECONDS)
        except subprocess.TimeoutExpired:
            self.process.kill()
            return self.process.wait()

    def _listen(self, lines: IO[str], told: "queue.SimpleQueue[Told]") -> None:
        """Put each line into the queue; runs in a thread."""
        with lines:
            for line in lines:
                told.put((self, line.rstrip("\n")))
        told.put((self, None))


def _start(environment: Mapping[str, str]) -> "subprocess.Popen[str]":
    """Start a worker, with one thread, and with more environment variables.

    It ends when its standard input is closed, as it is when this process ends (`harness.experiment.workers.worker`).
    """
    return subprocess.Popen(
        [sys.executable, *_path_flags(), "-m", "harness.experiment.workers.worker"],
        stdin=subprocess.PIPE,
        text=True,
        env={**os.environ, **ONE_THREAD, **environment},
        start_new_session=True,  # Ctrl-C reaches this process alone, which stops the others
        stdout=subprocess.PIPE,
    )


def _path_flags() -> list[str]:
    """Flags that keep a worker from importing from the working directory, if this process does not do so either."""
    return [] if sys.path[:1] in ([""], [os.getcwd()]) else ["-P"]


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
        with suppress(BrokenPipeError):  # it has ended, so what was not written does not matter
            process.stdin.close()
