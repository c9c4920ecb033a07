"""A word now and then: who watches a cell should not take it for one that hangs."""

import time

from harness.executor import Word
from harness.experiment.workers.order import Report

EVERY = 1.0
"""Seconds from one word to the next, at least."""


class Beat:
    """Says that the work gets on, as often as `EVERY` allows."""

    def __init__(self, report: Report) -> None:
        self._report, self._told = report, time.monotonic()

    def __call__(self, steps: int) -> None:
        """The work gets on; `steps` of the training are done."""
        if time.monotonic() >= self._told + EVERY:
            self._told = time.monotonic()
            self._report(Word(steps))
