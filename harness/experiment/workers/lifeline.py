"""How a process that works for another ends with it."""

import os
import queue
import threading
from collections.abc import Callable, Iterator


def lines_of_parent(on_done: Callable[[], None]) -> Iterator[str]:
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
