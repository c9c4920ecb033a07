"""``python -m harness.experiment.workers.worker``: the process in which an executor has things done, one after another.

Each line of standard input is an order (`harness.experiment.workers.order`). The answers are lines on standard output:
a `harness.executor.Word`, as often as there is news; then `DONE`, and the next order may come, or the output ends.
An order that would run on sources which have changed since this process began is answered with `STALE`, and not done.
What the work itself prints goes into its log, and so does the stack if the process crashes; what it reads is empty. The
process ends when its parent does.
"""

import faulthandler
import os
import platform
import queue
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import chdir
from functools import partial
from pathlib import Path
from typing import IO

from harness.experiment.run_cell import own_partial
from harness.experiment.workers.order import Order, read_order, tell
from harness.record.cell import write_log
from harness.record.folder import LOG
from harness.registry.given import is_plugin_file


def lines_of_parent(on_done: Callable[[], object]) -> Iterator[str]:
    """The lines that the parent writes to standard input, one after the other, until it closes it.

    Who takes a line is at work until it asks for the next one. If the parent ends in the meantime, this process ends at
    once. Standard input itself is empty from the first line on.

    Args:
        on_done: Called when the work for a line is over; from then on this process outlives the end of its input.
    """
    lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
    at_work = threading.Event()

    stdin = os.dup(0)
    with open(os.devnull) as nothing:
        os.dup2(nothing.fileno(), 0)

    def read() -> None:
        with os.fdopen(stdin) as stream:
            for line in stream:
                at_work.set()
                lines.put(line)
        if at_work.is_set():
            os._exit(1)
        lines.put(None)

    threading.Thread(target=read, daemon=True).start()
    while (line := lines.get()) is not None:
        yield line
        at_work.clear()
        on_done()


DONE, STALE = "done", "stale"


def main() -> None:
    """Do what standard input orders."""
    begun = time.time()
    faulthandler.enable()  # on standard error, which is the log of the order
    with os.fdopen(os.dup(1), "w", buffering=1) as parent:  # standard output: nothing else writes to it; line by line
        for number, line in enumerate(lines_of_parent(lambda: parent.write(f"{DONE}\n"))):
            if number and _is_stale(begun):
                parent.write(f"{STALE}\n")
                return
            order, sys.argv = read_order(line)  # the manifest records what the user typed
            if not _do(order, parent):
                return


def _do(order: Order, parent: IO[str]) -> bool:
    """Do an order; returns whether this process is fit for another."""
    log = own_partial(order.folder) / LOG
    print_into(log)
    write_log(log, f"process {os.getpid()} on {platform.node()} begins")
    try:
        with chdir("."):  # the next order begins where this one did
            return order.work.do(order.folder, partial(tell, parent))
    finally:
        print_into(Path(os.devnull))  # the log is finished: a thread that still prints must not change it


def print_into(path: Path) -> None:
    """Send standard output and standard error into a file from now on."""
    sys.stdout.flush()
    sys.stderr.flush()
    with path.open("a") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    # A killed process flushes nothing; and no training ends for a character that a plugin prints.
    sys.stdout.reconfigure(line_buffering=True, errors="backslashreplace")  # type: ignore[union-attr]


def _is_stale(begun: float) -> bool:
    """Whether a file that was imported has changed since: the manifest would name sources that did not run."""
    modules = [module for name, module in list(sys.modules.items()) if not is_plugin_file(name)]
    files = [getattr(module, "__file__", None) for module in modules]
    return any(_changed(file) > begun for file in files if file)


def _changed(file: str) -> float:
    try:
        status = os.stat(file)
        return max(status.st_mtime, status.st_ctime)  # a copy may bring an old time of change
    except OSError:
        return 0.0  # in an archive


if __name__ == "__main__":
    main()
