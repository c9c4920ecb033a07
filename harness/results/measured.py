"""What every metric says of one cell: of its policy in both manners, of random actions, and of its training."""

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import NamedTuple, TypeAlias, TypeVar

import numpy as np

from harness.errors import Unmeasured, reason_of
from harness.eta.headline import SUCCESS
from harness.metric import Metric
from harness.record.trace import Trace

Values: TypeAlias = dict[str, float | None]
"""By metric; None where it is not defined, and where the metric fails."""
Asked = TypeVar("Asked")

DETERMINISTIC, STOCHASTIC, TRAINING, LEARNING = "deterministic", "stochastic", "while training", "while learning"
AREA, STEPS_TO_GOAL = "success_area", "steps_to_goal"
GOAL = 0.9
"""Sample efficiency counts the steps until this share of the episodes succeeds."""


class Moment(NamedTuple):
    """One evaluation of one cell."""

    steps: int
    """Environment steps of training before it."""
    values: Values


class Measured(NamedTuple):
    """All of one cell."""

    manners: Mapping[str, Values]
    """Of the trained policy by how it acted, and of the training itself; in the order in which they are shown."""
    episodes: Mapping[str, int]
    """Finished episodes that each rests on."""
    random: Values
    """Of random actions."""
    reasons: Mapping[str, str] = {}
    """Of each metric that failed, why; its values are None."""

    @property
    def own(self) -> Values:
        """Of the trained policy, acting as the cell says: what stands first."""
        return next(iter(self.manners.values()))


def measure(metrics: Mapping[str, Metric], trace: Trace) -> Values:
    """Every metric of a trace; None where one fails."""
    values: Values = {}
    for name, metric in metrics.items():
        values[name] = None
        with suppress(Unmeasured):
            values[name] = value_of(metric, trace)
    return values


def value_of(metric: Metric, trace: Trace) -> float | None:
    """What a metric says of a trace.

    Raises:
        Unmeasured: It raises, or what it returns is no finite number.
    """

    def ask() -> float | None:
        value = metric(trace)
        if value is not None and not math.isfinite(value):
            raise Unmeasured(f"it returned {value}")
        return None if value is None else float(value)

    return unmeasured_if_it_raises(ask)


def unmeasured_if_it_raises(ask: Callable[[], Asked]) -> Asked:
    """What `ask` returns, which runs a metric's code: whatever that raises is a reason, and stops nobody else.

    Raises:
        Unmeasured: With the reason in one line.
    """
    try:
        return ask()
    except (Exception, SystemExit) as error:
        raise Unmeasured(reason_of(error)) from error


def moments_by_due(moments: Sequence[Moment], every: int, budget: int) -> list[tuple[int, Moment]]:
    """Evaluations with the multiple of `every` that each was due at; the last one at the budget.

    Algorithms that act for several steps at a time do not all hit a multiple.
    """
    return [(budget if moment.steps >= budget else moment.steps // every * every, moment) for moment in moments]


def learning_values(moments: Sequence[Moment], budget: int) -> Values:
    """How fast a cell learned: mean success over its evaluations, and the steps until `GOAL` of the episodes succeed.

    A training that never gets there counts with all of its steps. None where it was not evaluated while it learned.
    """
    known = [(moment.steps, value) for moment in moments if (value := moment.values.get(SUCCESS)) is not None]
    if len(moments) < 2 or len(known) < len(moments):
        return {AREA: None, STEPS_TO_GOAL: None}
    reached = [steps for steps, success in known if success >= GOAL]
    return {AREA: float(np.mean([success for _, success in known])), STEPS_TO_GOAL: float(min([*reached, budget]))}
