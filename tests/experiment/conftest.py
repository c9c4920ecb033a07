"""What tests of cells and workers share."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from harness.executor import CellOptions, Word
from harness.experiment.run_cell import TrainCell
from harness.experiment.workers.order import Order
from harness.experiment.workers.worker import DONE
from harness.record.cell import Cell
from harness.registry.given import Given

WORKER = [sys.executable, "-m", "harness.experiment.workers.worker"]


@pytest.fixture
def train_in_a_process() -> Callable[..., None]:
    """Do a cell in a worker of its own, which is killed when it has told of `until` steps, if it gets there."""

    def train(
        cell: Cell, folder: Path, every: int = 0, until: int | None = None, plugins: tuple[Given, ...] = ()
    ) -> None:
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
