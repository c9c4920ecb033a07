"""How a process that works for another ends with it."""

import os
import queue
import threading
from collections.abc import Callable, Iterator


def end_with_parent() -> None:
    """From now on this process ends when standard input closes, as it does when the parent ends, however it ends.

    Standard input itself is empty from then on: a plugin that reads it finds the end instead of waiting.
    """

    def wait(stdin: int) -> None:
        while os.read(stdin, 1):
            pass
        os._exit(1)

    _listen(wait)


def lines_of_parent(on_done: Callable[[], None]) -> Iterator[str]:
    """The lines that the parent writes to standard input, one after the other, until it closes it.

    Who takes a line is at work until it asks for the next one. If the parent ends in the meantime, this process ends at
    once. Standard input itself is empty from the first line on.

    Args:
        on_done: Called when the work for a line is over; from then on this process outlives the end of its input.
    """
    lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
    at_work = threading.Event()

    def read(stdin: int) -> None:
        with os.fdopen(stdin) as stream:
            for line in stream:
                at_work.set()
                lines.put(line)
        if at_work.is_set():
            os._exit(1)
        lines.put(None)

    _listen(read)
    while (line := lines.get()) is not None:
        yield line
        at_work.clear()
        on_done()


def _listen(listen: Callable[[int], None]) -> None:
    """In a thread, to what was standard input."""
    kept = os.dup(0)
    with open(os.devnull) as nothing:
        os.dup2(nothing.fileno(), 0)
    threading.Thread(target=listen, args=(kept,), daemon=True).start()
