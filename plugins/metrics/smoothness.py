"""How jerky the joints move."""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from harness.log import Log


@dataclass(frozen=True)
class Smoothness:
    """Root mean square of the second difference of the joint positions, per step squared; 0 at constant speed.

    It is computed for each joint over all finished episodes. The metric is the mean over the joints.
    """

    unit: ClassVar[str] = "rad/step^2"
    better: ClassVar[str] = "lower"
    bounds: ClassVar[tuple[float, float]] = (0.0, math.inf)

    def __call__(self, trace: Log) -> float | None:
        """None if no finished episode has two steps."""
        seconds = [np.diff(trace["qpos"][rows], n=2, axis=0) for rows in trace.episodes if len(rows) > 2]
        if not seconds:
            return None
        return float(np.sqrt(np.mean(np.concatenate(seconds) ** 2, axis=0)).mean())
