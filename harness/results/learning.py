"""The evaluations of a comparison's policies during their training. Reads results only."""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

from harness.eta.behaviour_change import Quantity
from harness.eta.index import SeedMean, mean_of_known
from harness.eta.interval import UNBOUNDED, Bounds
from harness.results.comparison import Group
from harness.results.metrics import Moment, Values, moments_by_due

STRETCHES = 20
"""How many stretches a training has, each a point of its curve: the mean over the episodes that ended in it."""


class Point(NamedTuple):
    """A point of a curve."""

    steps: int
    """Environment steps. It is the mean if the seeds were not evaluated after the same number of steps."""
    value: SeedMean

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {"steps": self.steps, **self.value.to_json()}


@dataclass(frozen=True)
class LearningCurve:
    """What a reward's policies did, over environment steps.

    Attributes:
        reward: The label of the reward.
        runs: The evaluations of each training by its seed, in order, the last one after it.
        points: By metric; the mean over seeds with its 95 % interval at each evaluation.
    """

    reward: str
    runs: Mapping[int, Sequence[Moment]]
    points: Mapping[str, tuple[Point, ...]]

    def known(self, metric: str) -> list[Point]:
        """The points at which the metric is defined."""
        return [point for point in self.points[metric] if point.value.mean is not None]

    def band(self, metric: str) -> list[tuple[int, float, float]]:
        """Steps and both ends of the interval, for all points that have one. Points of a single seed have none."""
        return [
            (point.steps, point.value.low, point.value.high)
            for point in self.points[metric]
            if point.value.low is not None and point.value.high is not None
        ]


@dataclass(frozen=True)
class Learning:
    """The learning curves of a comparison.

    Attributes:
        baseline: The curve of the baseline reward.
        proposed: The curve of the proposed reward.
        random: The values of random actions by metric; None if a value is not defined.
    """

    baseline: LearningCurve
    proposed: LearningCurve
    random: Values

    def to_json(self) -> dict[str, Any]:
        """Plain data: the curves by metric, and the runs that they are means of."""
        sides = {"baseline": self.baseline, "proposed": self.proposed}
        metrics = {
            name: {
                **{side: [it.to_json() for it in curve.points[name]] for side, curve in sides.items()},
                "random": value,
            }
            for name, value in self.random.items()
        }
        runs = {
            side: [
                {"seed": seed, "evaluations": [{"steps": steps, **values} for steps, values in moments]}
                for seed, moments in curve.runs.items()
            ]
            for side, curve in sides.items()
        }
        return {"metrics": metrics, "runs": runs}


def learning_points(runs: Collection[Sequence[Moment]], measure: Quantity, group: Group) -> tuple[Point, ...]:
    """The mean of one measure over seeds at each evaluation.

    Evaluations that were due at the same step form one point.
    """
    found: dict[int, list[Moment]] = {}
    for moments in runs:
        for due, moment in moments_by_due(moments, group.evaluate_every, group.steps):
            found.setdefault(due, []).append(moment)
    return tuple(
        mean_point(
            round(sum(it.steps for it in moments) / len(moments)),
            [*(it.values[measure.name] for it in moments), *[None] * (len(runs) - len(moments))],
            measure.ends,
        )
        for _, moments in sorted(found.items())
    )


def stretches(steps: int) -> Iterator[tuple[int, int]]:
    """Where the stretches of a training begin and end, in environment steps."""
    count = min(STRETCHES, steps)
    return pairwise(math.ceil(steps * place / count) for place in range(count + 1))


def mean_point(end: int, values: Sequence[float | None], bounds: Bounds = UNBOUNDED) -> Point:
    """The mean over seeds in a stretch.

    Args:
        end: Where the stretch ends, or when the policies were evaluated.
        values: The value of each seed; None where it has none.
        bounds: What a value can be.
    """
    return Point(end, mean_of_known(values, "seeds have no value here", bounds))
