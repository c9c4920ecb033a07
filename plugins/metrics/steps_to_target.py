"""How fast the target is reached."""

from dataclasses import dataclass
from typing import ClassVar

from harness.record.trace import Trace


@dataclass(frozen=True)
class StepsToTarget:
    """Mean number of steps to the target, over the finished episodes that reach it; the first time counts."""

    unit: ClassVar[str] = "steps"
    better: ClassVar[str] = "lower"

    def __call__(self, trace: Trace) -> float | None:
        """None if no episode reaches it."""
        reached, step = trace["reached"], trace["step"]
        steps = [step[rows[reached[rows].argmax()]] for rows in trace.episodes if reached[rows].any()]
        return float(sum(steps) / len(steps)) if steps else None
