"""How often the arm runs into the ground."""

from dataclasses import dataclass
from typing import ClassVar

from harness.log import Log


@dataclass(frozen=True)
class GroundHits:
    """Share of the finished episodes that end with the arm on the ground, in [0, 1]."""

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "lower"
    is_share: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode."""
        ends = trace.last_rows
        return float(trace["ground"][ends].mean()) if len(ends) else None
