"""How fast the target is reached."""

import math
from dataclasses import dataclass
from typing import ClassVar

from harness.log import Log

from ..way_to_target import steps_to_target


@dataclass(frozen=True)
class StepsToTarget:
    """Mean number of steps to the first target, over the successful episodes only.

    A policy that fails more often in the far corners gets a better value. `time_to_target` counts all episodes.
    """

    unit: ClassVar[str] = "steps"
    better: ClassVar[str] = "lower"
    bounds: ClassVar[tuple[float, float]] = (1.0, math.inf)

    def __call__(self, trace: Log) -> float | None:
        """None if no episode reaches a target."""
        steps = steps_to_target(trace)
        return float(steps[steps > 0].mean()) if steps.any() else None
