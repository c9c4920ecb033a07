"""The metric."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from harness.trace import Trace


@dataclass(frozen=True)
class Way:
    """Length of the end effector's way in an episode, mean."""

    unit: ClassVar[str] = "m"
    better: ClassVar[str] = "lower"

    def __call__(self, trace: Trace) -> float | None:
        """None if there is no episode."""
        position = np.stack([trace[f"end_effector_{axis}"] for axis in "xyz"], axis=1)
        ways = [float(np.linalg.norm(np.diff(position[rows], axis=0), axis=1).sum()) for rows in trace.episodes]
        return float(np.mean(ways)) if ways else None
