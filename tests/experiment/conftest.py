"""What tests of cells and workers share."""

import os
import signal
import subprocess
import sys

import pytest

from harness.executor import CellOptions, Word
from harness.experiment.run_cell import TrainCell, run_cell
from harness.experiment.workers.order import Order
from harness.experiment.workers.worker import DONE

WORKER = [sys.executable, "-m", "harness.experiment.workers.worker"]


@pytest.fixture
def train_in_a_process():
    """Do a cell in a worker of its own, which is killed when it has told of `until` steps, if it gets there."""

    def train(cell, folder, every=0, until=None, plugins=()):
        order = Order(folder, TrainCell(cell, CellOptions(checkpoint_every=every, plugins=plugins)))
        with subprocess.Popen(WORKER, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as worker:
            worker.stdin.write(order.line() + "\n")
            worker.stdin.flush()
            for line in worker.stdout:
                if line.strip() == DONE:
                    worker.stdin.close()
                elif until is not None and Word.from_line(line).steps >= until:
                    os.kill(worker.pid, signal.SIGKILL)
                    break
            worker.wait()

    return train


@pytest.fixture
def done(toys, tmp_path_factory):
    """The folder of a cell that was done without a break, only to be read: one that was done before is there."""

    def done(cell, **options):
        folder = tmp_path_factory.getbasetemp() / "done" / f"{cell.id} {options}"
        if not folder.exists():
            assert run_cell(cell, folder, lambda word: None, CellOptions(**options)).status == "done"
        return folder

    return done
