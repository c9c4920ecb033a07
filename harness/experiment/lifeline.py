"""How a process that works for another ends with it."""

import os
import threading


def end_with_parent() -> None:
    """From now on this process ends when standard input closes, as it does when the parent ends, however it ends.

    Standard input itself is empty from then on: a plugin that reads it finds the end instead of waiting.
    """
    kept = os.dup(0)
    with open(os.devnull) as nothing:
        os.dup2(nothing.fileno(), 0)
    threading.Thread(target=_wait_for_the_end, args=(kept,), daemon=True).start()


def _wait_for_the_end(stdin: int) -> None:
    while os.read(stdin, 1):
        pass
    os._exit(1)
