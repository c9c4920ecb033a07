"""The interface that a metric fills: a pure function of a trace that uses no reward."""

from typing import Protocol

from harness.eta.interval import SHARE, UNBOUNDED, Bounds
from harness.record.trace import Trace


class Metric(Protocol):
    """A frozen dataclass: how well a robot behaves, whatever it was paid.

    If the value is a mean over episodes of something between 0 and 1, set the class attribute ``is_share = True``. Its
    interval then allows for values near 0 and 1: if nearly all episodes give 1, a few seeds do not show how often an
    episode gives 0.

    If the value is a distance from the trace's column ``distance``, set ``is_error = True``. In a task with a goal of
    its own, see `harness.goal.Goal`, reports then show the metric with the name and the unit of the task's error.

    If the value cannot be below or above a number, say so by the class attribute ``bounds``, as
    ``bounds = (0.0, math.inf)`` for a length. No interval then leaves these bounds. Those of a share are known.
    """

    @property
    def unit(self) -> str:
        """Unit of the value; empty if it has none."""

    @property
    def better(self) -> str:
        """``higher`` or ``lower``."""

    def __call__(self, trace: Trace) -> float | None:
        """The value over all finished episodes of a trace; None where it is not defined."""


def is_share(metric: Metric) -> bool:
    """Whether a metric says that it is a share of episodes, or a mean over them of something between 0 and 1."""
    return bool(getattr(metric, "is_share", False))


def bounds_of(metric: Metric) -> Bounds:
    """The least and the greatest value that a metric says it can have."""
    return SHARE if is_share(metric) else getattr(metric, "bounds", UNBOUNDED)


def is_error(metric: Metric) -> bool:
    """Whether a metric says that its values are those of the task's error."""
    return bool(getattr(metric, "is_error", False))
