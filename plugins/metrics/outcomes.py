"""Metrics of how an episode ends: whether, how near and how soon the target is reached."""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from harness.log import Log
from harness.record.trace import OBSTACLE, episode_facts

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
    is_time: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode, or if the trace does not record the control period.

        It is also None if an episode fails and the trace does not record the horizon.
        """
        steps, facts = steps_to_target(trace), episode_facts(trace)
        if len(steps) == 0 or facts.control_period is None or (facts.horizon is None and not steps.all()):
            return None
        return float(np.where(steps > 0, steps, facts.horizon or 0).mean() * facts.control_period)


@dataclass(frozen=True)
class StepsToTarget:
    """Mean number of steps to the first target, over the successful episodes only.

    A policy that fails more often in the far corners gets a better value. `time_to_target` counts all episodes.
    """

    unit: ClassVar[str] = "steps"
    better: ClassVar[str] = "lower"
    bounds: ClassVar[tuple[float, float]] = (1.0, math.inf)
    is_time: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None if no episode reaches a target."""
        steps = steps_to_target(trace)
        return float(steps[steps > 0].mean()) if steps.any() else None


@dataclass(frozen=True)
class ObstacleHits:
    """Share of the finished episodes that end with the arm at an obstacle, in [0, 1].

    Only tasks that have obstacles have this metric.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "lower"
    is_share: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode, or if the task has no obstacles."""
        ends = trace.last_rows
        return float(trace[OBSTACLE][ends].mean()) if OBSTACLE in trace.columns and len(ends) else None


@dataclass(frozen=True)
class GroundHits:
    """Share of the finished episodes that end with the arm on the ground, in [0, 1]."""

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "lower"
    is_share: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode."""
        ends = trace.last_rows
        return float(trace["ground"][ends].mean()) if len(ends) else None


@dataclass(frozen=True)
class Timeouts:
    """Share of the finished episodes whose time runs out before they reach the target, in [0, 1].

    Without obstacles, three shares add up to 1: this one, `success_rate`, and the share of episodes that end on the
    ground before they reach a target. If reaching the target ends an episode, `ground_hits` is the third share, but it
    also counts a step that reaches the target and hits the ground. If episodes go on after a target, `ground_hits` also
    counts those that hit the ground after their first target.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "lower"
    is_share: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode."""
        reached, truncated = trace["reached"], trace["truncated"]
        over = [bool(truncated[rows[-1]]) and not reached[rows].any() for rows in trace.episodes]
        return sum(over) / len(over) if over else None


@dataclass(frozen=True)
class ClosestDistance:
    """Smallest distance from end effector to target in an episode, [m]; mean over the finished episodes.

    The distance at the start counts too. If the task measures another error, such as a pose error, the metric takes
    that error in its unit. If no episode ends at the target, or all end on the ground, this metric says more than
    `final_distance`.
    """

    unit: ClassVar[str] = "m"
    better: ClassVar[str] = "lower"
    bounds: ClassVar[tuple[float, float]] = (0.0, math.inf)
    is_error: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode."""
        closest = [float(trace["distance"][rows].min()) for rows in trace.episodes]
        return sum(closest) / len(closest) if closest else None


@dataclass(frozen=True)
class FinalDistance:
    """Mean distance from end effector to target at the end of the finished episodes, [m].

    If the task measures another error, such as a pose error, the metric takes that error in its unit.
    """

    unit: ClassVar[str] = "m"
    better: ClassVar[str] = "lower"
    bounds: ClassVar[tuple[float, float]] = (0.0, math.inf)
    is_error: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode."""
        ends = trace.last_rows
        return float(trace["distance"][ends].mean()) if len(ends) else None


@dataclass(frozen=True)
class SuccessRate:
    """Share of the finished episodes in which the target is reached, in [0, 1]."""

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"
    is_share: ClassVar[bool] = True

    def __call__(self, trace: Log) -> float | None:
        """None without a finished episode."""
        reached = [trace["reached"][rows].any() for rows in trace.episodes]
        return sum(reached) / len(reached) if reached else None
