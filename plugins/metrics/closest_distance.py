"""How near to the target an episode comes."""

from dataclasses import dataclass
from typing import ClassVar

from harness.record.trace import Trace


@dataclass(frozen=True)
class ClosestDistance:
    """Mean over the finished episodes of the smallest distance from end effector to target, the start's included, [m].

    Of a task with another error that error, in its unit. Where no episode ends at the target, or all end on the ground,
    this tells more than where they end.
    """

    unit: ClassVar[str] = "m"
    better: ClassVar[str] = "lower"
    is_error: ClassVar[bool] = True

    def __call__(self, trace: Trace) -> float | None:
        """None without a finished episode."""
        closest = [float(trace["distance"][rows].min()) for rows in trace.episodes]
        return sum(closest) / len(closest) if closest else None
