"""What policies came to over the steps of their training: in evaluations, or in stretches of the training itself."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

from harness.eta.index import Estimate, mean_of_known
from harness.eta.interval import UNBOUNDED, Bounds
from harness.files.plain import tells, to_plain
from harness.results.metrics import Moment, Values

STRETCHES = 20
"""How many stretches a training has, each a point of its curve: the mean over the episodes that ended in it."""


@tells("steps", "*mean")
class Point(NamedTuple):
    """A point of a curve."""

    steps: int
    """Environment steps. It is the mean if the seeds were not evaluated after the same number of steps."""
    mean: Estimate


@dataclass(frozen=True)
class LearningCurve:
    """What a reward's policies did, over environment steps.

    Attributes:
        reward: The label of the reward.
        of: What a point is a mean of, in words that end a sentence.
        runs: The evaluations of each training by its seed, in order, the last one after it; empty where a point is one
            of the training.
        points: By metric, or what an episode was paid; the mean over seeds with its 95 % interval.
    """

    reward: str
    of: str
    runs: Mapping[int, Sequence[Moment]]
    points: Mapping[str, tuple[Point, ...]]

    def known(self, metric: str) -> list[Point]:
        """The points at which the metric is defined."""
        return [point for point in self.points[metric] if point.mean.value is not None]

    def band(self, metric: str) -> list[tuple[int, float, float]]:
        """Steps and both ends of the interval, for all points that have one. Points of a single seed have none."""
        return [
            (point.steps, point.mean.low, point.mean.high)
            for point in self.points[metric]
            if point.mean.low is not None and point.mean.high is not None
        ]


@dataclass(frozen=True)
class Learning:
    """Learning curves that are drawn together.

    Attributes:
        curves: That of the baseline reward and that of the proposed one; or of a reward that nothing is compared with.
        random: The values of random actions by metric; None if a value is not defined, or not what a point is of.
    """

    curves: tuple[LearningCurve, ...]
    random: Values

    def known(self, metric: str) -> list[Point]:
        """The points of all curves at which the metric is defined."""
        return [point for curve in self.curves for point in curve.known(metric)]

    def to_json(self) -> dict[str, Any]:
        """Plain data of two: the curves by metric, and the runs that they are means of."""
        sides = dict(zip(("baseline", "proposed"), self.curves, strict=True))
        metrics = {
            name: {**{side: curve.points[name] for side, curve in sides.items()}, "random": value}
            for name, value in self.random.items()
        }
        runs = {
            side: [
                {"seed": seed, "evaluations": [{"steps": steps, **values} for steps, values in moments]}
                for seed, moments in curve.runs.items()
            ]
            for side, curve in sides.items()
        }
        return {"of": self.curves[0].of, "metrics": to_plain(metrics), "runs": runs}


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
