"""Orders done in Python processes of this machine, several at once, one thread each.

A process does one order after the other, so that it imports the heavy libraries once. It is replaced after
`ORDERS_PER_PROCESS`, after an order that failed, and where an order asks for a fresh one.
"""

import os
import queue
import signal
import subprocess
import sys
import threading
import time
import uuid
from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Final, Literal, NamedTuple, Self, TypeAlias

import psutil

from harness.errors import UsageError
from harness.executor import NO_SCALARS, Limits, Word
from harness.experiment.workers.order import Order
from harness.experiment.workers.worker import DONE, STALE
from harness.record.cell import write_log
from harness.record.folder import LOG, partial_folder

VARIABLE: Final = "HARNESS_OFFSPRING"
"""Environment variable that a process hands on to those that it starts."""
LONGEST: Final = 2.0
"""Seconds after which processes are left alone that do not end: the system holds them."""
SEARCH_EVERY: Final = 0.02
"""Seconds between two looks for processes: while some are ended, others may start new ones."""


@dataclass(frozen=True)
class Offspring:
    """Processes with one mark in their environment. A process inherits it, also from one that has ended meanwhile.

    A process that was started with an environment of its own has no mark, and is not found.

    Attributes:
        mark: No other processes have it.
    """

    mark: str = field(default_factory=lambda: uuid.uuid4().hex)

    @property
    def environment(self) -> dict[str, str]:
        """What the first of them has to get."""
        return {VARIABLE: self.mark}

    def kill(self) -> None:
        """End all of them at once."""
        until = time.monotonic() + LONGEST
        while (found := list(self._living())) and time.monotonic() < until:
            for process in found:
                with suppress(psutil.Error):  # it has ended, or is another user's
                    process.kill()
            time.sleep(SEARCH_EVERY)

    @contextmanager
    def ended_at_once(self) -> Iterator[None]:
        """If an exception passes, as after Ctrl-C, they are ended: nothing that they do is worth waiting for."""
        try:
            yield
        except BaseException:
            self.kill()
            raise

    def _living(self) -> Iterator[psutil.Process]:
        for process in psutil.process_iter():
            try:
                is_ours = process.pid != os.getpid() and process.environ().get(VARIABLE) == self.mark
                if is_ours and process.status() != psutil.STATUS_ZOMBIE:
                    yield process
            except (psutil.Error, OSError):  # it has ended, or is another user's
                continue


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
    # It imports from the working directory only if this process does so too.
    flags = [] if sys.path[:1] in ([""], [os.getcwd()]) else ["-P"]
    return subprocess.Popen(
        [sys.executable, *flags, "-m", "harness.experiment.workers.worker"],
        stdin=subprocess.PIPE,
        text=True,
        env={**os.environ, **ONE_THREAD, **environment},
        start_new_session=True,  # Ctrl-C reaches this process alone, which stops the others
        stdout=subprocess.PIPE,
    )


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


ORDERS_PER_PROCESS = 50
"""A process is replaced after so many orders, because libraries may leak memory in each."""


class News(NamedTuple):
    """Something that happened to an order."""

    kind: Literal["started", "progress", "ended"]
    folder: Path
    """The folder of the order."""
    steps: int = 0
    reason: str = ""
    """Why the process of an ended order left no folder; empty if it left one."""
    scalars: Mapping[str, float] = NO_SCALARS
    """The scalars of progress, see `harness.executor.Word`."""
    status: int | None = None
    """With a `reason`: the exit status of the process; negative: the number of the signal that ended it."""
    over_limit: bool = False
    """With a `reason`: whether the process was ended because it took more than the order's limits."""


OnNews: TypeAlias = Callable[[News], None]


def core_count() -> int:
    """Cores that this process may use; on systems that do not say it, as macOS and Windows, those of the machine."""
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
    """Have every order done by a process, at most `at_once` at a time.

    Whatever a process does, crash and kill included, the others go on. A process that takes more than its order's
    limits is ended. When an exception passes, KeyboardInterrupt above all, none is left running.

    Args:
        orders: What to do, in this order.
        at_once: How many processes.
        on_news: Called in this thread: ``started``, any number of ``progress``, then ``ended``, once for every order.
    """
    with Pool() as pool:
        for news in pool.run(orders, at_once):
            on_news(news)


@dataclass
class _Task:
    """An order that a process is doing."""

    order: Order
    watchdog: Watchdog
    ended_for: str = ""
    """Why its process was told to end; empty if it was not."""
    seen_ended: bool = False
    """Whether its process was found to have ended while its output was open."""


@dataclass
class Pool:
    """The worker processes, and one queue of their answers. Some do an order, some wait for one, some end.

    They are ended when the ``with`` block of the pool ends.

    Attributes:
        environment: Variables that the processes have beside those of this process.
    """

    environment: Mapping[str, str] = field(default_factory=dict)
    busy: dict[WorkerProcess, _Task] = field(default_factory=dict)
    idle: list[WorkerProcess] = field(default_factory=list)
    leaving: list[WorkerProcess] = field(default_factory=list)
    told: "queue.SimpleQueue[Told]" = field(default_factory=queue.SimpleQueue)
    clock: Clock = field(default_factory=Clock)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def run(self, orders: Sequence[Order], at_once: int) -> Iterator[News]:
        """Have every order done, and tell what happens; see `run_orders`. The pool may do more orders after these."""
        waiting = deque(orders)
        while waiting or self.busy:
            while waiting and len(self.busy) < at_once:
                order = waiting.popleft()
                yield News("started", order.folder)
                self.give(order)
            yield from self.look()

    def give(self, order: Order) -> None:
        """Have an order done by a process that waits, or by a new one."""
        partial_folder(order.folder).mkdir(parents=True, exist_ok=True)  # gone again when the order is done
        process = self._process_for(order)
        self.busy[process] = _Task(order, Watchdog(order.limits, self.clock))
        process.give(order)

    def _process_for(self, order: Order) -> WorkerProcess:
        while self.idle and not order.fresh:
            process = self.idle.pop()
            if process.process.poll() is None:
                return process
            self.leaving.append(process)  # something ended it while it waited
        return WorkerProcess(self.told, self.environment)

    def look(self) -> list[News]:
        """Wait a little for answers, and end processes that exceed their limits."""
        try:
            told = self.told.get(timeout=LOOK_EVERY)
        except queue.Empty:
            told = None
        self.clock.look()
        news = self._ended_in_silence() if told is None else self._hear(told)
        for process, task in self.busy.items():
            if not task.ended_for:
                self._watch(process, task)
        return news

    def stop(self) -> None:
        """End all processes. Those that wait for an order end by themselves, or are killed after a while."""
        for process in self.idle:
            process.close()
        stop_processes([process.process for process in self.busy])
        for process in (*self.idle, *self.leaving):
            process.end()
        self.busy.clear()
        self.idle.clear()
        self.leaving.clear()

    def _hear(self, told: Told) -> list[News]:
        process, line = told
        if process not in self.busy:  # it has no order, and has ended
            process.end()
            self.idle = [one for one in self.idle if one is not process]
            self.leaving = [one for one in self.leaving if one is not process]
            return []
        task = self.busy[process]
        if line is None or line == STALE:
            return self._lost(process, task, is_stale=line == STALE)
        if line != DONE:
            task.watchdog.hear()
            word = Word.from_line(line)
            return [News("progress", task.order.folder, word.steps, scalars=word.scalars)]
        del self.busy[process]
        self._keep(process, task.order)
        return [News("ended", task.order.folder)]

    def _ended_in_silence(self) -> list[News]:
        """Deal with processes that have ended while others, which they started, keep their output open.

        What they wrote last may still be on its way: they are given up at the second look.
        """
        ended = [(process, task) for process, task in self.busy.items() if process.process.poll() is not None]
        known = [(process, task) for process, task in ended if task.seen_ended]
        for _, task in ended:
            task.seen_ended = True
        return [news for process, task in known for news in self._lost(process, task, is_stale=False)]

    def _keep(self, process: WorkerProcess, order: Order) -> None:
        """Let a process that has done an order wait for the next one, if it may do another."""
        if order.fresh or process.given >= ORDERS_PER_PROCESS:
            process.close()
            self.leaving.append(process)
        else:
            self.idle.append(process)

    def _lost(self, process: WorkerProcess, task: _Task, is_stale: bool) -> list[News]:
        """Deal with a process that ends: after its order, in the middle of it, or before it."""
        del self.busy[process]
        status = process.end()
        if is_stale:
            self.give(task.order)
            return []
        folder = task.order.folder
        if not partial_folder(folder).exists():
            return [News("ended", folder)]
        reason = task.ended_for or _reason(status, task.order)
        return [News("ended", folder, reason=reason, status=status, over_limit=bool(task.ended_for))]

    def _watch(self, process: WorkerProcess, task: _Task) -> None:
        complaint = task.watchdog.complaint(process.memory)
        if complaint:
            task.ended_for = complaint
            write_log(partial_folder(task.order.folder) / LOG, f"{complaint}: its process is ended, its stack follows")
            process.abort()


def _reason(status: int, order: Order) -> str:
    if status < 0:
        return f"its process was ended by {signal.Signals(-status).name}"
    return f"its process ended with exit status {status} before the {order.work.noun} did"
