"""How returns and behaviour went while the policies learned, as figures show it."""

import math
from collections.abc import Sequence

from harness.eta.interval import UNBOUNDED, Bounds
from harness.eta.seed_mean import mean_over_seeds
from harness.results.comparison import Comparison
from harness.results.learning import Learning, LearningCurve, Point
from harness.results.recordings.episodes import Part
from harness.results.recordings.runs import Run, Runs

STRETCHES = 20
"""Of a training, each a point of its curve: the mean over the episodes that ended in it."""


def return_name(reward: str) -> str:
    """What the curve of a reward is called."""
    return f"return paid by {reward}"


def learning_of(runs: Runs, comparison: Comparison) -> Learning | None:
    """Every measure and every reward over the steps of both trainings; None without a seed."""
    if not comparison.seeds:
        return None
    baseline, proposed = (
        _curve(runs, reward, [runs.members[reward, seed] for seed in comparison.seeds])
        for reward in (comparison.baseline, comparison.proposed)
    )
    return Learning(baseline, proposed, dict.fromkeys(baseline.points))


def _curve(runs: Runs, reward: str, members: Sequence[Run]) -> LearningCurve:
    ends = [math.ceil(runs.steps * (place + 1) / STRETCHES) for place in range(min(STRETCHES, runs.steps))]
    stretches = [
        (end, [run.episodes.part(begin, end) for run in members]) for begin, end in zip([0, *ends], ends, strict=False)
    ]
    points = {name: tuple(_point(end, parts, name, runs) for end, parts in stretches) for name in runs.measures}
    for paid in runs.rewards:
        points[return_name(paid)] = tuple(_return_point(end, parts, paid) for end, parts in stretches)
    return LearningCurve(reward, (), points)


def _point(end: int, parts: Sequence[Part], measure: str, runs: Runs) -> Point:
    values = [part.behaviour.get(measure) for part in parts]
    episodes = min(part.episodes for part in parts) if runs.is_flag(measure) else None
    return _mean(end, values, episodes, runs.bounds(measure))


def _return_point(end: int, parts: Sequence[Part], reward: str) -> Point:
    return _mean(end, [part.returns.get(reward) for part in parts])


def _mean(end: int, values: Sequence[float | None], episodes: int | None = None, bounds: Bounds = UNBOUNDED) -> Point:
    known = [value for value in values if value is not None]
    missing = (
        None if len(known) == len(values) else f"{len(values) - len(known)} of {len(values)} seeds have no value here"
    )
    return Point(end, mean_over_seeds(known, missing, episodes, bounds))
