"""How fast the target is reached, beside the arm's own kinematics."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from harness.record.trace import Trace

from ..way_to_target import steps_to_target


@dataclass(frozen=True)
class Optimality:
    """Steps that the arm's own kinematics take to the target over the steps that the policy takes, mean.

    Over the finished episodes in which the kinematics reach the target; one in which the policy fails counts 0. The
    kinematics go to one pose as fast as the joints can, which is seldom the nearest: a value above 1 says that the
    policy is faster, and is not cut off.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"

    def __call__(self, trace: Trace) -> float | None:
        """None where the trace does not tell the kinematics' steps, or no finished episode counts."""
        if trace.facts.ik_steps is None:
            return None
        ik_steps = [trace.facts.ik_steps[trace["env"][rows[0]]] for rows in trace.episodes]
        pairs = zip(ik_steps, steps_to_target(trace), strict=True)
        shares = [ik / steps if steps else 0.0 for ik, steps in pairs if ik is not None]
        return float(np.mean(shares)) if shares else None
