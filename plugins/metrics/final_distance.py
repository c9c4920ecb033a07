"""How far from the target an episode ends."""

import math
from dataclasses import dataclass
from typing import ClassVar

from harness.log import Log


@dataclass(frozen=True)
class FinalDistance:
    """Mean distance from end effector to target at the end of the finished episodes, [m].

    If the task measures another error, such as a pose error, the metric takes that error in its unit.
    """

    unit: ClassVar[str] = "m"
    better: ClassVar[str] = "lower"
    bounds: ClassVar[tuple[float, float]] = (0.0, math.inf)
    is_error: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode."""
        ends = trace.last_rows
        return float(trace["distance"][ends].mean()) if len(ends) else None
