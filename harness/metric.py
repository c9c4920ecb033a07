"""The interface that a metric fills: a pure function of a trace that uses no reward."""

from typing import Protocol

from harness.record.trace import Trace


class Metric(Protocol):
    """A frozen dataclass: how well a robot behaves, whatever it was paid."""

    @property
    def unit(self) -> str:
        """Of the value; empty where it has none."""

    @property
    def better(self) -> str:
        """``higher`` or ``lower``."""

    def __call__(self, trace: Trace) -> float | None:
        """The value over all finished episodes of a trace; None where it is not defined."""
