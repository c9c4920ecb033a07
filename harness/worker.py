"""The process in which an executor runs one cell: ``python -m harness.worker``.

Reads one line of JSON, the cell and its folder, from standard input; writes the number of steps done, a line each, to
standard output. What the cell itself prints goes into its log; what it reads is empty. Ends when its parent does.
"""

import json
import os
import sys
import threading
from pathlib import Path
from typing import IO

from harness.cell import Cell
from harness.cell_folder import LOG, partial_folder
from harness.run_cell import run_cell


def main() -> None:
    """Do the cell that standard input names."""
    order = json.loads(sys.stdin.readline())
    cell, folder = Cell.from_json(order["cell"]), Path(order["folder"])
    sys.argv = order["command"]  # the manifest records what the user typed
    threading.Thread(target=_end_with_parent, args=(_keep_stdin(),), daemon=True).start()
    partial = partial_folder(folder)
    partial.mkdir(parents=True, exist_ok=True)
    with _keep_stdout() as parent, (partial / LOG).open("a") as log:
        os.dup2(log.fileno(), 1)
        os.dup2(log.fileno(), 2)
        sys.stdout.reconfigure(line_buffering=True)  # type: ignore[union-attr]  # a killed process flushes nothing

        def progress(steps: int) -> None:
            parent.write(f"{int(steps)}\n")
            parent.flush()

        run_cell(cell, folder, progress)


def _keep_stdout() -> IO[str]:
    """Standard output under another number, so that nothing else writes to it."""
    return os.fdopen(os.dup(1), "w")


def _keep_stdin() -> int:
    """Standard input under another number; a plugin that reads its own finds the end of it instead of waiting."""
    kept = os.dup(0)
    with open(os.devnull) as nothing:
        os.dup2(nothing.fileno(), 0)
    return kept


def _end_with_parent(stdin: int) -> None:
    """Standard input closes when the parent ends, however it ends."""
    while os.read(stdin, 1):
        pass
    os._exit(1)


if __name__ == "__main__":
    main()
