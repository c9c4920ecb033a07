"""How direct the way to the target is."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from harness.record.trace import Trace

from ..way_to_target import paths_to_target


@dataclass(frozen=True)
class PathRatio:
    """Length of the end effector's path to the target over the straight line from its start to its end, mean, >= 1.

    Over the successful episodes only, up to the first time that they reach the target: of the others the end is
    anywhere. One that ends where it began has no straight line, and does not count. `spl` counts all episodes.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "lower"

    def __call__(self, trace: Trace) -> float | None:
        """None if no episode reaches the target, away from its start."""
        path, straight = paths_to_target(trace).T
        counts = straight > 0.0
        return float(np.mean(path[counts] / straight[counts])) if counts.any() else None
