"""How often the arm runs into an obstacle."""

from dataclasses import dataclass
from typing import ClassVar

from harness.log import Log
from harness.record.trace import OBSTACLE


@dataclass(frozen=True)
class ObstacleHits:
    """Share of the finished episodes that end with the arm at an obstacle, in [0, 1].

    Only tasks that have obstacles have this metric.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "lower"
    is_share: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode, or if the task has no obstacles."""
        ends = trace.last_rows
        return float(trace[OBSTACLE][ends].mean()) if OBSTACLE in trace.columns and len(ends) else None
