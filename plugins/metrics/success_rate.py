"""How often the target is reached."""

from dataclasses import dataclass
from typing import ClassVar

from harness.trace import Trace


@dataclass(frozen=True)
class SuccessRate:
    """Share of the finished episodes that end within epsilon of the target, in [0, 1]."""

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"

    def __call__(self, trace: Trace) -> float | None:
        """None without a finished episode."""
        ends = trace.last_rows
        return float(trace["reached"][ends].mean()) if len(ends) else None
