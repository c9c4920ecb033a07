"""How often the time is over before the target is reached."""

from dataclasses import dataclass
from typing import ClassVar

from harness.log import Log


@dataclass(frozen=True)
class Timeouts:
    """Share of the finished episodes whose time runs out before they reach the target, in [0, 1].

    Without obstacles, three shares add up to 1: this one, `success_rate`, and the share of episodes that end on the
    ground before they reach a target. If reaching the target ends an episode, `ground_hits` is the third share, but it
    also counts a step that reaches the target and hits the ground. If episodes go on after a target, `ground_hits` also
    counts those that hit the ground after their first target.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "lower"
    is_share: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode."""
        reached, truncated = trace["reached"], trace["truncated"]
        over = [bool(truncated[rows[-1]]) and not reached[rows].any() for rows in trace.episodes]
        return sum(over) / len(over) if over else None
