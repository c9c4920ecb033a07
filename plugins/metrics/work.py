"""How much mechanical work the motion takes."""

from dataclasses import dataclass
from typing import ClassVar

from harness.record.trace import Trace


@dataclass(frozen=True)
class Work:
    """Mean mechanical work of a finished episode, [J]: what the joints put into the links at least.

    The sum of all gains in kinetic and potential energy from row to row, see `harness.robot.energy.least_work`: what
    comes back when the energy falls is lost, and friction is not counted. An arm that stands still does no work: read
    it beside the success rate.
    """

    unit: ClassVar[str] = "J"
    better: ClassVar[str] = "lower"

    def __call__(self, trace: Trace) -> float | None:
        """None where the trace does not tell it, or without a finished episode."""
        if trace.facts.work is None or not trace.episodes:
            return None
        works = [trace.facts.work[trace["env"][rows[0]]] for rows in trace.episodes]
        return float(sum(works) / len(works))
