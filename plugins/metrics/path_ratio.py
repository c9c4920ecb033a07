"""How direct the way to the target is."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from harness.record.trace import Trace


@dataclass(frozen=True)
class PathRatio:
    """Length of the end effector's path to the target over the straight line from its start to its end, mean, >= 1.

    Over the episodes that reach the target, up to the first time: of the others the end is anywhere. One that ends
    where it began has no straight line, and does not count.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "lower"

    def __call__(self, trace: Trace) -> float | None:
        """None if no episode reaches the target, away from its start."""
        position = np.stack([trace[f"end_effector_{axis}"] for axis in "xyz"], axis=1)
        ratios = []
        for rows in trace.episodes:
            reached = trace["reached"][rows]
            if reached.any():
                path = position[rows[: reached.argmax() + 1]]
                straight = float(np.linalg.norm(path[-1] - path[0]))
                if straight > 0.0:
                    ratios.append(float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()) / straight)
        return float(np.mean(ratios)) if ratios else None
