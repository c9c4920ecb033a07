"""Reports progress now and then, so that a working cell is not taken for one that hangs."""

import time

from harness.executor import Word
from harness.experiment.workers.order import Report

EVERY = 1.0
"""The least seconds between two reports."""


class Beat:
    """Reports that the work goes on, as often as `EVERY` allows."""

    def __init__(self, report: Report) -> None:
        self._report, self._told = report, time.monotonic()

    def __call__(self, steps: int) -> None:
        """Report that the work goes on, with `steps` of the training done, if a report is due."""
        if time.monotonic() >= self._told + EVERY:
            self._told = time.monotonic()
            self._report(Word(steps))
