"""How much mechanical work the motion takes."""

import math
from dataclasses import dataclass
from typing import ClassVar

from harness.log import Log
from harness.record.episode_facts import episode_facts


@dataclass(frozen=True)
class Work:
    """Mean mechanical work of a finished episode, [J]: the least that the joints must have put into the links.

    It is the sum of all gains in kinetic and potential energy from row to row, see `harness.robot.energy.least_work`.
    Energy that comes back when it falls counts as lost. Friction is not counted. An arm that stands still does no work,
    so read this metric together with the success rate.
    """

    unit: ClassVar[str] = "J"
    better: ClassVar[str] = "lower"
    bounds: ClassVar[tuple[float, float]] = (0.0, math.inf)

    def __call__(self, trace: Log) -> float | None:
        """None if the trace does not record the work, or without a finished episode."""
        work = episode_facts(trace).work
        if work is None or not trace.episodes:
            return None
        works = [work[trace["env"][rows[0]]] for rows in trace.episodes]
        return float(sum(works) / len(works))
