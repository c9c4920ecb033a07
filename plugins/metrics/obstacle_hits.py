"""How often the arm runs into an obstacle."""

from dataclasses import dataclass
from typing import ClassVar

from harness.record.trace import OBSTACLE, Trace


@dataclass(frozen=True)
class ObstacleHits:
    """Share of the finished episodes that end with the arm at an obstacle, in [0, 1]; of tasks that have obstacles."""

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "lower"
    is_share: ClassVar[bool] = True

    def __call__(self, trace: Trace) -> float | None:
        """None without a finished episode, and where the task has no obstacles."""
        ends = trace.last_rows
        return float(trace[OBSTACLE][ends].mean()) if OBSTACLE in trace.columns and len(ends) else None
