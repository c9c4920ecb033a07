"""The interface that a measure fills: what a robot does, whatever it was paid.

A metric is a registered one. A user may also write a plain function of a step or of an episode in a file; the registry
makes a measure of it, see `harness.registry.measure_functions`.
"""

from typing import Protocol

from harness.eta.interval import SHARE, UNBOUNDED, Bounds
from harness.log import Log


class Measure(Protocol):
    """A frozen dataclass: how well a robot behaves, whatever it was paid.

    If the value is a mean over episodes of something between 0 and 1, set the class attribute ``is_share = True``. Its
    interval then allows for values near 0 and 1: if nearly all episodes give 1, a few seeds do not show how often an
    episode gives 0.

    If the value is a distance from the trace's column ``distance``, set ``is_error = True``. In a task with a goal of
    its own, see `harness.goal.Goal`, reports then show the metric with the name and the unit of the task's error.

    If the value cannot be below or above a number, say so by the class attribute ``bounds``, as
    ``bounds = (0.0, math.inf)`` for a length. No interval then leaves these bounds. Those of a share are known.

    If it is a time in an episode, in steps or in seconds, set ``is_time = True``: it ends at the horizon of the task.

    If it reads joint speeds, say so by ``needs = frozenset({"qvel"})``: an experiment then records them.
    """

    @property
    def unit(self) -> str:
        """Unit of the value; empty if it has none."""

    @property
    def better(self) -> str:
        """``higher`` or ``lower``; empty where nobody says it."""

    def __call__(self, trace: Log) -> float | None:
        """The value over all finished episodes of a trace; None where it is not defined."""


def is_share(measure: Measure) -> bool:
    """Whether a measure says that it is a share of episodes, or a mean over them of something between 0 and 1."""
    return bool(getattr(measure, "is_share", False))


def bounds_of(measure: Measure) -> Bounds:
    """The least and the greatest value that a measure says it can have."""
    return SHARE if is_share(measure) else getattr(measure, "bounds", UNBOUNDED)


def is_time(measure: Measure) -> bool:
    """Whether a measure says that it is a time in an episode, in steps, or in seconds if that is its unit."""
    return bool(getattr(measure, "is_time", False))


def is_error(measure: Measure) -> bool:
    """Whether a measure says that its values are those of the task's error."""
    return bool(getattr(measure, "is_error", False))


def needs_of(measure: Measure) -> frozenset[str]:
    """What a measure says that it reads of a trace, by names of `harness.reward.steps.ARM`; often nothing."""
    return frozenset(getattr(measure, "needs", ()))
