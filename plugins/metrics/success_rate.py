"""How often the target is reached."""

from dataclasses import dataclass
from typing import ClassVar

from harness.log import Log


@dataclass(frozen=True)
class SuccessRate:
    """Share of the finished episodes in which the target is reached, in [0, 1]."""

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"
    is_share: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode."""
        reached = [trace["reached"][rows].any() for rows in trace.episodes]
        return sum(reached) / len(reached) if reached else None
