"""Orders done in Python processes of this machine, several at once, one thread each.

A process does one order after the other, so that it imports the heavy libraries once. It is replaced after
`ORDERS_PER_PROCESS`, after an order that failed, and where an order asks for a fresh one.
"""

import os
import queue
import signal
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, NamedTuple, Self, TypeAlias

from harness.errors import UsageError
from harness.executor import NO_SCALARS, Word
from harness.experiment.workers.order import Order
from harness.experiment.workers.process import LOOK_EVERY, Clock, Told, Watchdog, WorkerProcess, stop_processes
from harness.experiment.workers.worker import DONE, STALE
from harness.record.folder import LOG, partial_folder
from harness.record.manifest import write_log

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
