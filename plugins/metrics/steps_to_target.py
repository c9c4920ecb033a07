"""How fast the target is reached."""

from dataclasses import dataclass
from typing import ClassVar

from harness.trace import Trace


@dataclass(frozen=True)
class StepsToTarget:
    """Mean number of steps of the episodes that reach the target."""

    unit: ClassVar[str] = "steps"
    better: ClassVar[str] = "lower"

    def __call__(self, trace: Trace) -> float | None:
        """None if no episode reaches it."""
        ends = trace.last_rows
        steps = trace["step"][ends][trace["reached"][ends]]
        return float(steps.mean()) if len(steps) else None
