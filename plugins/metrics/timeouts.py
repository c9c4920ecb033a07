"""How often the time is over before the target is reached."""

from dataclasses import dataclass
from typing import ClassVar

from harness.record.trace import Trace


@dataclass(frozen=True)
class Timeouts:
    """Share of the finished episodes that are truncated, the target not reached in them, in [0, 1].

    This share, that of `success_rate`, and that of the episodes that end on the ground before they reach a target make
    1. `ground_hits` is the last of these where reaching the target ends the episode, but for a step that does both;
    where episodes go on, it counts those as well that hit the ground after their first target.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "lower"
    is_share: ClassVar[bool] = True

    def __call__(self, trace: Trace) -> float | None:
        """None without a finished episode."""
        reached, truncated = trace["reached"], trace["truncated"]
        over = [bool(truncated[rows[-1]]) and not reached[rows].any() for rows in trace.episodes]
        return sum(over) / len(over) if over else None
