"""What every metric says of one cell: of its policy in both manners, of random actions, and of its training."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from harness.eta.headline import SUCCESS
from harness.metric import Metric
from harness.record.trace import Trace

Values: TypeAlias = dict[str, float | None]
"""By metric; None where it is not defined."""

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

    @property
    def own(self) -> Values:
        """Of the trained policy, acting as the cell says: what stands first."""
        return next(iter(self.manners.values()))


def measure(metrics: Mapping[str, Metric], trace: Trace) -> Values:
    """Every metric of a trace."""
    return {name: metric(trace) for name, metric in metrics.items()}


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
