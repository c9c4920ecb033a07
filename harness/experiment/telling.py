"""What both worlds tell: that they go on, now and then, and what an evaluation came to."""

import time
from collections.abc import Mapping
from types import MappingProxyType

from harness.executor import Word
from harness.experiment.workers.order import Report
from harness.progress import TERMS

TELL_EVERY = 1.0
"""Seconds from one time to tell what was learned to the next."""
SECTION, PAID = "Evaluation", "Cumulative Reward"
"""The first part of each name, and the name of what an episode was paid; both are those of Unity ML-Agents."""


NO_TERMS: Mapping[str, float | None] = MappingProxyType({})


def named_scalars(
    paid: float | None, measures: Mapping[str, float | None], terms: Mapping[str, float | None] = NO_TERMS
) -> dict[str, float]:
    """Numbers by their names for trackers, such as ``Evaluation/Success Rate``. What is None is left out.

    Args:
        paid: Mean over episodes of what the reward of the training paid.
        measures: Means over episodes of what no reward enters, by name, as ``success_rate``.
        terms: Means over episodes of what each term of that reward paid, by name.
    """
    values = {PAID: paid, **{name.replace("_", " ").title(): value for name, value in measures.items()}}
    values |= {f"{TERMS}/{name}": value for name, value in terms.items()}
    return {f"{SECTION}/{name}": float(value) for name, value in values.items() if value is not None}


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
