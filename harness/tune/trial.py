"""The results of a search: its trials, and which is best."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

from harness.tune.outcome import Outcome

Status: TypeAlias = Literal["running", "complete", "pruned", "failed", "refused"]
"""``pruned``: got no more seeds. ``refused``: the algorithm does not take this combination of values."""

FORMAT = 1


@dataclass(frozen=True)
class TrialRecord:
    """The settings of a trial and its result.

    Attributes:
        number: Counted from 0 in each search.
        status: How it stands.
        params: The values of what is searched.
        outcome: Mean over its cells so far; None without any.
        value: What a complete trial is worth, see `harness.tune.outcome.score`.
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
