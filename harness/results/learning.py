"""The evaluations of a comparison's policies during their training. Reads results only."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from harness.eta.headline import SUCCESS
from harness.eta.interval import SHARE, UNBOUNDED, Bounds
from harness.eta.seed_mean import SeedMean, mean_over_seeds
from harness.measure import bounds_of, is_share
from harness.record.cell import Cell
from harness.results.cell_results import PAID
from harness.results.comparison import Comparison, Group
from harness.results.measured import Moment, Values, moments_by_due
from harness.results.records import Records

STRETCHES = 20
"""How many stretches a training has, each a point of its curve: the mean over the episodes that ended in it."""


@dataclass(frozen=True)
class LearningRun:
    """The evaluations of one cell, the last one after its training.

    Attributes:
        seed: The seed of the cell.
        moments: The evaluations in order.
    """

    seed: int
    moments: tuple[Moment, ...]


class Point(NamedTuple):
    """A point of a curve."""

    steps: int
    """Environment steps. It is the mean if the seeds were not evaluated after the same number of steps."""
    value: SeedMean


@dataclass(frozen=True)
class LearningCurve:
    """What a reward's policies did, over environment steps.

    Attributes:
        reward: The label of the reward.
        runs: One run per seed.
        points: By metric; the mean over seeds with its 95 % interval at each evaluation.
    """

    reward: str
    runs: tuple[LearningRun, ...]
    points: Mapping[str, tuple[Point, ...]]

    def known(self, metric: str) -> list[Point]:
        """The points at which the metric is defined."""
        return [point for point in self.points[metric] if point.value.mean is not None]

    def band(self, metric: str) -> list[tuple[int, float, float]]:
        """Steps and both ends of the interval, for all points that have one. Points of a single seed have none."""
        return [
            (point.steps, point.value.low, point.value.high)
            for point in self.known(metric)
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
        return {
            "metrics": {
                name: {
                    **{side: [_point_to_json(point) for point in curve.points[name]] for side, curve in sides.items()},
                    "random": self.random[name],
                }
                for name in self.random
            },
            "runs": {side: [_run_to_json(run) for run in curve.runs] for side, curve in sides.items()},
        }


def learning_of(results: Records, combination: Comparison) -> Learning | None:
    """The learning curves of a combination: of evaluations, or where there are none of the training itself.

    Of all trainings of each reward. None for the null control, and where one has none.

    Raises:
        SchemaError: A file is damaged or written by a newer version.
    """
    if combination.is_control or not combination.has_trainings:
        return None
    sides = list(zip((combination.baseline, combination.proposed), combination.trained, strict=True))
    if combination.group.evaluate_every:
        baseline, proposed = (_curve(results, combination, *it) for it in sides)
        if any(len(run.moments) > 1 for curve in (baseline, proposed) for run in curve.runs):
            random = {change.name: change.random for change in combination.changes_of(combination.own_manner)}
            return Learning(baseline, proposed, random)
    baseline, proposed = (
        curve_of_training(results, combination.group, label, _cells_of(results, combination.group, label, seeds))
        for label, seeds in sides
    )
    return Learning(baseline, proposed, dict.fromkeys(baseline.points))


def learning_points(
    runs: Sequence[LearningRun], metric: str, group: Group, is_share: bool = False, bounds: Bounds = UNBOUNDED
) -> tuple[Point, ...]:
    """The mean of one metric, which may be a share of episodes or have bounds, over seeds at each evaluation.

    Evaluations that were due at the same step form one point.
    """
    found: dict[int, list[Moment]] = {}
    for run in runs:
        for due, moment in moments_by_due(run.moments, group.evaluate_every, group.steps):
            found.setdefault(due, []).append(moment)
    episodes = group.evaluation_episodes if is_share else None
    return tuple(_point(moments, metric, len(runs), episodes, bounds) for _, moments in sorted(found.items()))


def stretches(steps: int) -> Iterator[tuple[int, int]]:
    """Where the stretches of a training begin and end, in environment steps."""
    count = min(STRETCHES, steps)
    ends = [math.ceil(steps * (place + 1) / count) for place in range(count)]
    return zip([0, *ends], ends, strict=False)


def mean_point(
    end: int, values: Sequence[float | None], episodes: int | None = None, bounds: Bounds = UNBOUNDED
) -> Point:
    """The mean over seeds in a stretch.

    Args:
        end: Where the stretch ends.
        values: The value of each seed; None where it has none.
        episodes: How many episodes it is a share of, if it is one.
        bounds: What a value can be.
    """
    known = [value for value in values if value is not None]
    missing = (
        None if len(known) == len(values) else f"{len(values) - len(known)} of {len(values)} seeds have no value here"
    )
    return Point(end, mean_over_seeds(known, missing, episodes, bounds))


def curve_of_training(results: Records, group: Group, label: str, cells: Sequence[Cell]) -> LearningCurve:
    """Success, and what the own reward paid, of the episodes that ended in each stretch of the training.

    Args:
        results: The records.
        group: What the trainings share.
        label: Of their reward.
        cells: The trainings.
    """
    learned = [results.learned(cell) for cell in cells]
    success, paid = [], []
    for begin, end in stretches(group.steps):
        ended = [it[1:, slice(*np.searchsorted(it[0], [begin, end]))] for it in learned]
        means = [it.mean(axis=1).tolist() if it.shape[1] else (None, None) for it in ended]
        fewest = min(it.shape[1] for it in ended)
        success.append(mean_point(end, [it[0] for it in means], fewest or None, SHARE))
        paid.append(mean_point(end, [it[1] for it in means]))
    return LearningCurve(label, (), {SUCCESS: tuple(success), PAID: tuple(paid)})


def _point(moments: list[Moment], metric: str, seeds: int, episodes: int | None, bounds: Bounds) -> Point:
    values = [value for moment in moments if (value := moment.values[metric]) is not None]
    missing = None if len(values) == seeds else f"{seeds - len(values)} of {seeds} seeds have no value here"
    steps = round(sum(moment.steps for moment in moments) / len(moments))
    return Point(steps, mean_over_seeds(values, missing, episodes, bounds))


def _curve(results: Records, combination: Comparison, label: str, seeds: Sequence[int]) -> LearningCurve:
    cells = _cells_of(results, combination.group, label, seeds)
    runs = tuple(LearningRun(cell.seed, results.moments(cell)) for cell in cells)
    points = {
        name: learning_points(runs, name, combination.group, is_share(metric), bounds_of(metric))
        for name, metric in results.metrics.items()
    }
    return LearningCurve(label, runs, points)


def _cells_of(results: Records, group: Group, label: str, seeds: Sequence[int]) -> list[Cell]:
    """The done cells of a reward with these seeds, in their order."""
    found = {cell.seed: cell for cell in results.done_cells if Group.of(cell) == group and cell.reward.label == label}
    return [found[seed] for seed in seeds]


def _point_to_json(point: Point) -> dict[str, Any]:
    return {"steps": point.steps, **point.value.to_json()}


def _run_to_json(run: LearningRun) -> dict[str, Any]:
    return {"seed": run.seed, "evaluations": [{"steps": steps, **values} for steps, values in run.moments]}
