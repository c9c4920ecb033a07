"""Every metric check has a broken metric that fails it, and no other."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from harness.log import Log
from harness_plugins.kit import METRIC_CHECKS, metrics, violations


@dataclass
class Thawed:
    """Its parameters can be changed while it runs."""

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"

    def __call__(self, trace: Log) -> float | None:
        return share_reached(trace)


@dataclass(frozen=True)
class Sound:
    """The share of finished episodes that reach the target: nothing is wrong with it."""

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"

    def __call__(self, trace: Log) -> float | None:
        return share_reached(trace)


def share_reached(trace: Log) -> float | None:
    """The value of `Sound`."""
    reached = [trace["reached"][rows].any() for rows in trace.episodes]
    return float(np.mean(reached)) if reached else None


@dataclass(frozen=True)
class SetUpWithASet(Sound):
    """JSON knows no sets."""

    zones: frozenset[int] = frozenset({1})


class CannotDecide(Sound):
    """It says neither higher nor lower."""

    better = "best"


class DividesByNothing(Sound):
    """Where no episode reaches the target, there is no number to tell."""

    def __call__(self, trace: Log) -> float | None:
        value = share_reached(trace)
        return float("nan") if value == 0.0 else value


class NeedsFacts(Sound):
    """It takes for granted that a trace tells its horizon."""

    def __call__(self, trace: Log) -> float | None:
        share = share_reached(trace)
        return None if share is None else share * trace.facts.horizon


class CountsInNumpy(Sound):
    """The value is an integer."""

    def __call__(self, trace: Log) -> float | None:
        return int(trace["reached"].sum()) if len(trace) else None


class TakesNothingForZero(Sound):
    """An empty trace has the value 0."""

    def __call__(self, trace: Log) -> float | None:
        return share_reached(trace) if len(trace) else 0.0


class NeverTells(Sound):
    """The value is never defined."""

    def __call__(self, trace: Log) -> float | None:
        return None


class ReadsTheReward(Sound):
    """It tells what the episodes were paid in the end."""

    def __call__(self, trace: Log) -> float | None:
        ends = trace.last_rows
        return float(trace["reward"][ends].mean()) if len(ends) else None


class LooksAtTheLastRow(Sound):
    """It takes the end of the trace for the end of an episode."""

    def __call__(self, trace: Log) -> float | None:
        return float(trace["distance"][-1]) if len(trace) else None


class RemembersOnSelf(Sound):
    """It tells the change since the trace before, where there is one."""

    known = 0.0

    def __call__(self, trace: Log) -> float | None:
        value = float(trace["distance"][trace.last_rows].sum())
        known = 0.0 if value == self.known else self.known
        object.__setattr__(self, "known", value)
        return value - known if len(trace) else None


class SortsTheTrace(Sound):
    """It puts a column in order."""

    def __call__(self, trace: Log) -> float | None:
        trace["distance"].sort()
        return share_reached(trace)


class OverflowsInALongTrace(Sound):
    """It multiplies something of every row."""

    def __call__(self, trace: Log) -> float | None:
        with np.errstate(over="ignore"):
            factor = float(np.prod(np.full(len(trace), 2.0)))
        return share_reached(trace) if np.isfinite(factor) else factor


MUTANTS = {
    OverflowsInALongTrace: metrics.the_value_is_finite_or_none,
    Thawed: metrics.settings_are_frozen,
    SetUpWithASet: metrics.settings_survive_json,
    CannotDecide: metrics.unit_and_better_are_declared,
    DividesByNothing: metrics.the_value_is_finite_or_none,
    NeedsFacts: metrics.the_value_is_finite_or_none,
    CountsInNumpy: metrics.the_value_is_finite_or_none,
    TakesNothingForZero: metrics.an_empty_trace_has_no_value,
    NeverTells: metrics.a_full_trace_has_a_value,
    ReadsTheReward: metrics.rewards_do_not_matter,
    LooksAtTheLastRow: metrics.unfinished_episodes_do_not_count,
    RemembersOnSelf: metrics.traces_do_not_depend_on_one_another,
    SortsTheTrace: metrics.the_trace_is_left_alone,
}


def failing(mutant: type) -> list[str]:
    """Names of the checks that a mutant fails."""
    return [violation.check for violation in violations(METRIC_CHECKS, mutant())]


def test_mutant_fails_one_check(subtests: pytest.Subtests):
    """A metric that is broken in one way fails the check of that fact, and no other."""
    for mutant, check in MUTANTS.items():
        with subtests.test(mutant=mutant, check=check):
            assert failing(mutant) == [check.name]


def test_every_check_has_a_mutant():
    """No check is without a metric that fails it alone."""
    assert set(MUTANTS.values()) == set(METRIC_CHECKS)


def test_the_mutants_are_made_of_a_sound_metric():
    """What the mutants are made of fails nothing."""
    assert failing(Sound) == []
    assert np.isfinite(Sound()(metrics.recorded_trace(0, metrics.ALL_ENDS)))
