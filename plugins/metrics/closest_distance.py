"""How near to the target an episode comes."""

import math
from dataclasses import dataclass
from typing import ClassVar

from harness.log import Log


@dataclass(frozen=True)
class ClosestDistance:
    """Smallest distance from end effector to target in an episode, [m]; mean over the finished episodes.

    The distance at the start counts too. If the task measures another error, such as a pose error, the metric takes
    that error in its unit. If no episode ends at the target, or all end on the ground, this metric says more than
    `final_distance`.
    """

    unit: ClassVar[str] = "m"
    better: ClassVar[str] = "lower"
    bounds: ClassVar[tuple[float, float]] = (0.0, math.inf)
    is_error: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode."""
        closest = [float(trace["distance"][rows].min()) for rows in trace.episodes]
        return sum(closest) / len(closest) if closest else None
