"""The process in which an executor has one thing done: ``python -m harness.experiment.worker``.

Reads one line, the order (`harness.experiment.order`), from standard input; writes the number of steps done, a line
each, to standard output. What the work itself prints goes into its log; what it reads is empty. Ends when its parent
does.
"""

import os
import sys
from typing import IO

from harness.experiment.lifeline import end_with_parent
from harness.experiment.order import read_order
from harness.record.folder import LOG, partial_folder


def main() -> None:
    """Do what standard input orders."""
    order, sys.argv = read_order(sys.stdin.readline())  # the manifest records what the user typed
    end_with_parent()
    partial = partial_folder(order.folder)
    partial.mkdir(parents=True, exist_ok=True)
    with _keep_stdout() as parent, (partial / LOG).open("a") as log:
        os.dup2(log.fileno(), 1)
        os.dup2(log.fileno(), 2)
        sys.stdout.reconfigure(line_buffering=True)  # type: ignore[union-attr]  # a killed process flushes nothing

        def report(steps: int) -> None:
            parent.write(f"{int(steps)}\n")
            parent.flush()

        order.work.do(order.folder, report)


def _keep_stdout() -> IO[str]:
    """Standard output under another number, so that nothing else writes to it."""
    return os.fdopen(os.dup(1), "w")


if __name__ == "__main__":
    main()
