"""What a trial is worth: behaviour alone, never what a reward pays."""

import statistics
from collections.abc import Sequence
from typing import NamedTuple

from harness.metric import Metric
from harness.record.trace import Trace

JUDGES = ("success_rate", "final_distance")
"""The metrics that an outcome is made of."""


class Outcome(NamedTuple):
    """How a policy did in the validation episodes."""

    success: float
    """Share of the episodes that reach the target."""
    final_distance: float
    """Mean distance at the end of an episode, [m]."""


def outcome_of(trace: Trace, success_rate: Metric, final_distance: Metric) -> Outcome:
    """The outcome that a validation recorded.

    Raises:
        ValueError: No episode was finished.
    """
    success, distance = success_rate(trace), final_distance(trace)
    if success is None or distance is None:
        raise ValueError("no validation episode was finished")
    return Outcome(success, distance)


def mean_outcome(outcomes: Sequence[Outcome]) -> Outcome:
    """The mean outcome of several policies with equal weights."""
    return Outcome(
        statistics.fmean(outcome.success for outcome in outcomes),
        statistics.fmean(outcome.final_distance for outcome in outcomes),
    )


def score(outcome: Outcome, episodes: int) -> float:
    """One number to maximise: success, and among equals the final distance.

    Args:
        outcome: Of a trial.
        episodes: All that may enter it; one of them more or less is the least difference between two successes.

    Returns:
        The success, and less than half of that least difference on top, the more the nearer the arm ends: it orders
        trials of equal success, all those that never succeed above all, and no others.
    """
    return outcome.success + 0.5 / (episodes * (1.0 + outcome.final_distance))
