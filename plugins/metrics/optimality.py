"""How fast a policy reaches the target, compared with the arm's inverse kinematics."""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from harness.log import Log
from harness.record.episode_facts import episode_facts

from ..way_to_target import steps_to_target


@dataclass(frozen=True)
class Optimality:
    """Steps that inverse kinematics take to the target, divided by the steps that the policy takes; mean over episodes.

    The mean is over the finished episodes whose target inverse kinematics reach. An episode in which the policy fails
    counts 0. Inverse kinematics drive the joints to one pose as fast as they can. That pose is seldom the nearest one,
    so the policy may be faster: the value is then above 1.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"
    bounds: ClassVar[tuple[float, float]] = (0.0, math.inf)

    def __call__(self, trace: Log) -> float | None:
        """None if the trace does not record the steps of inverse kinematics, or if no episode counts."""
        of_env = episode_facts(trace).ik_steps
        if of_env is None:
            return None
        ik_steps = [of_env[trace["env"][rows[0]]] for rows in trace.episodes]
        pairs = zip(ik_steps, steps_to_target(trace), strict=True)
        shares = [ik / steps if steps else 0.0 for ik, steps in pairs if ik is not None]
        return float(np.mean(shares)) if shares else None
