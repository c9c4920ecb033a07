"""The process in which an executor runs one cell: ``python -m harness.experiment.worker``.

Reads one line of JSON, the order, from standard input; writes the number of steps done, a line each, to standard
output. What the work itself prints goes into its log; what it reads is empty. Ends when its parent does.

An order has ``folder``, which it has to leave, ``command``, what the user typed, and either ``cell``, to be trained
and evaluated, with ``checkpoint_every``, steps, if it is to leave checkpoints, and ``tensorboard``, whether to leave
event files, or with ``timed_from``, what the clock showed, if it is to leave its times; or ``policy_of``, a done cell's
folder, and ``simulator``, where its policy is to be evaluated.
"""

import json
import os
import sys
import threading
from pathlib import Path
from typing import IO, Any

from harness.experiment.cell_progress import Report
from harness.experiment.run_cell import run_cell
from harness.record.cell import Cell
from harness.record.folder import LOG, partial_folder
from harness.registry.choice import Choice
from harness.transfer.evaluation import evaluate_elsewhere


def main() -> None:
    """Do what standard input orders."""
    order = json.loads(sys.stdin.readline())
    folder = Path(order["folder"])
    sys.argv = order["command"]  # the manifest records what the user typed
    threading.Thread(target=_end_with_parent, args=(_keep_stdin(),), daemon=True).start()
    partial = partial_folder(folder)
    partial.mkdir(parents=True, exist_ok=True)
    with _keep_stdout() as parent, (partial / LOG).open("a") as log:
        os.dup2(log.fileno(), 1)
        os.dup2(log.fileno(), 2)
        sys.stdout.reconfigure(line_buffering=True)  # type: ignore[union-attr]  # a killed process flushes nothing

        def report(steps: int) -> None:
            parent.write(f"{int(steps)}\n")
            parent.flush()

        _do(order, folder, report)


def _do(order: dict[str, Any], folder: Path, report: Report) -> None:
    if "timed_from" in order:
        from harness.bench.timed_cell import run_timed  # who is not timed does not wait for it

        run_timed(Cell.from_json(order["cell"]), folder, report, order["timed_from"])
    elif "cell" in order:
        options = order.get("checkpoint_every", 0), order.get("tensorboard", False)
        run_cell(Cell.from_json(order["cell"]), folder, report, *options)
    else:
        evaluate_elsewhere(Path(order["policy_of"]), Choice.from_json(order["simulator"]), folder)


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
