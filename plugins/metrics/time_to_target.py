"""How long it takes until the target is reached, failures included."""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from harness.log import Log
from harness.record.episode_facts import episode_facts

from ..way_to_target import steps_to_target


@dataclass(frozen=True)
class TimeToTarget:
    """Mean time to the first target over all finished episodes, [s]. A failed episode counts as the whole horizon.

    This is the restricted mean of survival analysis. How an episode fails does not matter: if it ends on the ground,
    the target is not reached before the horizon either.
    """

    unit: ClassVar[str] = "s"
    better: ClassVar[str] = "lower"
    bounds: ClassVar[tuple[float, float]] = (0.0, math.inf)

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode, or if the trace does not record the control period.

        It is also None if an episode fails and the trace does not record the horizon.
        """
        steps, facts = steps_to_target(trace), episode_facts(trace)
        if len(steps) == 0 or facts.control_period is None or (facts.horizon is None and not steps.all()):
            return None
        return float(np.where(steps > 0, steps, facts.horizon or 0).mean() * facts.control_period)
