"""A trial of a search and what it is worth: behaviour alone, never what a reward pays."""

import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeAlias

from harness.authoring.commands import episodes_of, facts_of, value_of
from harness.log import Log
from harness.measure import Measure

JUDGES = ("success_rate", "final_distance")
"""The metrics that an outcome is made of."""
Status: TypeAlias = Literal["running", "complete", "pruned", "failed", "refused"]
"""``pruned``: got no more seeds. ``refused``: the algorithm does not take this combination of values."""

FORMAT = 1


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


@dataclass(frozen=True)
class TrialRecord:
    """The settings of a trial and its result.

    Attributes:
        number: Counted from 0 in each search.
        status: How it stands.
        params: The values of what is searched.
        outcome: Mean over its cells so far; None without any.
        value: What a complete trial is worth, see `harness_plugins.tune.trial.score`.
        cells: How many trainings entered the outcome.
        reason: Why it failed or was refused.
    """

    number: int
    status: Status
    params: dict[str, Any]
    outcome: Outcome | None
    value: float | None
    cells: int
    reason: str

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "number": self.number,
            "status": self.status,
            "params": {key: list(value) if isinstance(value, tuple) else value for key, value in self.params.items()},
            **self._outcome_to_json(),
            "cells": self.cells,
            "reason": self.reason,
        }

    def _outcome_to_json(self) -> dict[str, float | None]:
        outcome = self.outcome
        if outcome is not None and outcome.final_distance is None:
            return {outcome.measure: outcome.success}
        return {
            "success_rate": outcome.success if outcome else None,
            "final_distance": outcome.final_distance if outcome else None,
        }


@dataclass(frozen=True)
class Search:
    """The trials of one search.

    Attributes:
        rewards: Labels of the rewards that each trial was trained under.
        trials: By number.
    """

    rewards: tuple[str, ...]
    trials: tuple[TrialRecord, ...]

    @property
    def best(self) -> TrialRecord | None:
        """The complete trial with the largest value, the first of equals; None if no trial is complete."""
        complete = [trial for trial in self.ranked if trial.value is not None]
        return complete[0] if complete else None

    @property
    def ranked(self) -> list[TrialRecord]:
        """Complete trials, the best first, then the others by number."""
        return sorted(self.trials, key=lambda trial: (trial.value is None, -(trial.value or 0.0), trial.number))

    @property
    def failed(self) -> list[TrialRecord]:
        """Trials with a cell that failed."""
        return [trial for trial in self.trials if trial.status == "failed"]

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "rewards": list(self.rewards),
            "best": self.best.number if self.best else None,
            "trials": [trial.to_json() for trial in self.trials],
        }


@dataclass(frozen=True)
class Tuned:
    """All searches in a folder.

    Attributes:
        folder: Of the tuning.
        searches: One for all rewards, or one for each.
        file: The experiment with the best settings; None while a search has no complete trial.
    """

    folder: Path
    searches: tuple[Search, ...]
    file: Path | None

    @property
    def failed(self) -> list[TrialRecord]:
        """Trials with a cell that failed, of all searches."""
        return [trial for search in self.searches for trial in search.failed]

    def to_json(self) -> dict[str, Any]:
        """What ``harness tune --json`` prints."""
        return {
            "format": FORMAT,
            "folder": str(self.folder),
            "file": str(self.file) if self.file else None,
            "searches": [search.to_json() for search in self.searches],
        }
