"""The process in which an executor runs one cell: ``python -m harness.worker``.

Reads one line of JSON, the cell and its folder, from standard input; writes the number of steps done, a line each, to
standard output. What the cell itself prints goes into its log. Ends when its parent does.
"""

import json
import os
import sys
import threading
from pathlib import Path
from typing import IO

from harness.cell import Cell
from harness.run_cell import LOG, partial_folder, run_cell


def main() -> None:
    """Do the cell that standard input names."""
    order = json.loads(sys.stdin.readline())
    cell, folder = Cell.from_json(order["cell"]), Path(order["folder"])
    sys.argv = order["command"]  # the manifest records what the user typed
    threading.Thread(target=_end_with_parent, daemon=True).start()
    partial = partial_folder(folder)
    partial.mkdir(parents=True, exist_ok=True)
    with _keep_stdout() as parent, (partial / LOG).open("a") as log:
        os.dup2(log.fileno(), 1)
        os.dup2(log.fileno(), 2)

        def progress(steps: int) -> None:
            parent.write(f"{steps}\n")
            parent.flush()

        run_cell(cell, folder, progress)


def _keep_stdout() -> IO[str]:
    """Standard output under another number, so that nothing else writes to it."""
    return os.fdopen(os.dup(1), "w")


def _end_with_parent() -> None:
    """Standard input closes when the parent ends, however it ends."""
    sys.stdin.read()
    os._exit(1)


if __name__ == "__main__":
    main()
