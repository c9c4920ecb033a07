"""What a trial is worth: behaviour alone, never what a reward pays."""

import statistics
from collections.abc import Sequence
from typing import NamedTuple

from harness.log import Log
from harness.measure import Measure
from harness.record.recording.facts import facts_of
from harness.results.measured import value_of
from harness.results.recordings.episodes import episodes_of

JUDGES = ("success_rate", "final_distance")
"""The metrics that an outcome is made of."""


class Outcome(NamedTuple):
    """How a policy did in the validation episodes."""

    success: float
    """Share of the episodes that reach the target; in an environment, and where one is named, the measure that decides.
    """
    final_distance: float | None
    """Mean distance at the end of an episode, [m]; None where another measure decides."""
    measure: str = ""
    """The name of the measure that decides in an environment, or that is named; empty of success."""
    better: str = "higher"
    """Which values of that measure are better: ``higher`` or ``lower``."""


def outcome_of(trace: Log, success_rate: Measure, final_distance: Measure) -> Outcome:
    """The outcome that a validation of an arm recorded.

    Raises:
        ValueError: No episode was finished.
    """
    success, distance = success_rate(trace), final_distance(trace)
    if success is None or distance is None:
        raise ValueError("no validation episode was finished")
    return Outcome(success, distance)


def outcome_by(name: str, measure: Measure, trace: Log) -> Outcome:
    """The outcome that a validation of an arm recorded, by the measure that decides.

    Raises:
        Unmeasured: The measure fails.
        ValueError: It has no value.
    """
    value = value_of(measure, trace)
    if value is None:
        raise ValueError(f"{name} is not known: no validation episode was finished")
    return Outcome(value, None, name, measure.better)


def outcome_in_environment(recording: Log) -> Outcome:
    """The outcome that a validation in an environment recorded.

    Raises:
        ValueError: Nothing measures what the agent does, or the measure that decides is not known.
    """
    facts = facts_of(recording)
    if not facts.behaviour:
        raise ValueError("no measure says what the agent does, and a reward cannot judge: give --measure behaviour.py")
    name = facts.behaviour[0]
    part = episodes_of(recording).whole
    value = part.behaviour[name]
    if value is None:
        raise ValueError(f"{name} is not known: {part.reasons.get(name, 'no validation episode was finished')}")
    return Outcome(value, None, name, "lower" if name in facts.lower_is_better else "higher")


def mean_outcome(outcomes: Sequence[Outcome]) -> Outcome:
    """The mean outcome of several policies with equal weights."""
    distances = [outcome.final_distance for outcome in outcomes if outcome.final_distance is not None]
    success = statistics.fmean(outcome.success for outcome in outcomes)
    return outcomes[0]._replace(success=success, final_distance=statistics.fmean(distances) if distances else None)


def score(outcome: Outcome, episodes: int) -> float:
    """One number to maximise: success, and among equals the final distance; in an environment what decides there.

    Args:
        outcome: Of a trial.
        episodes: All that may enter it; one of them more or less is the least difference between two successes.

    Returns:
        The success, and less than half of that least difference on top, the more the nearer the arm ends: it orders
        trials of equal success, all those that never succeed above all, and no others. In an environment the measure
        that decides, with its sign changed if less is better.
    """
    if outcome.final_distance is None:
        return -outcome.success if outcome.better == "lower" else outcome.success
    return outcome.success + 0.5 / (episodes * (1.0 + outcome.final_distance))
