"""How direct the way to the target is."""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from harness.log import Log

from ..way_to_target import paths_to_target


@dataclass(frozen=True)
class PathRatio:
    """Length of the end effector's path to the target, divided by the straight line between the path's ends.

    The metric is the mean over the successful episodes, >= 1. A path ends when its episode first reaches the target.
    Failed episodes do not count, because they may end anywhere; `spl` counts them. A path that ends where it began does
    not count either, because it has no straight line.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "lower"
    bounds: ClassVar[tuple[float, float]] = (1.0, math.inf)

    def __call__(self, trace: Log) -> float | None:
        """None if no episode counts."""
        path, straight = paths_to_target(trace).T
        counts = straight > 0.0
        return float(np.mean(path[counts] / straight[counts])) if counts.any() else None
