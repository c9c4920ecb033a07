"""How returns and behaviour went while the policies learned, as figures show it."""

from collections.abc import Sequence

from harness.results.comparison import Comparison
from harness.results.learning import Learning, LearningCurve, Point, mean_point, stretches
from harness.results.recordings.episodes import Part
from harness.results.recordings.runs import Run, Runs


def return_name(reward: str) -> str:
    """What the curve of a reward is called."""
    return f"return paid by {reward}"


def learning_of(runs: Runs, comparison: Comparison) -> Learning | None:
    """Every measure and every reward over the steps of all trainings of both; None where one has none."""
    if not comparison.has_trainings:
        return None
    baseline, proposed = (
        curve_of(runs, reward, [runs.members[reward, seed] for seed in seeds])
        for reward, seeds in zip((comparison.baseline, comparison.proposed), comparison.trained, strict=True)
    )
    floor = runs.random.whole.behaviour if runs.random else {}
    return Learning(baseline, proposed, {name: floor.get(name) for name in baseline.points})


def curve_of(runs: Runs, reward: str, members: Sequence[Run]) -> LearningCurve:
    """Every measure and every reward over the steps of the trainings by one reward."""
    parts = _evaluated(runs, members) or [
        (end, [run.episodes.part(begin, end) for run in members]) for begin, end in stretches(runs.steps)
    ]
    points = {name: tuple(_point(end, of, name, runs) for end, of in parts) for name in runs.measures}
    for paid in runs.rewards:
        points[return_name(paid)] = tuple(_return_point(end, of, paid) for end, of in parts)
    return LearningCurve(reward, (), points)


def _evaluated(runs: Runs, members: Sequence[Run]) -> list[tuple[int, list[Part]]]:
    """What policies did in the evaluations that all trainings have; empty if there are none before the end."""
    every = runs.group.evaluate_every
    if not every or not all(run.before and run.evaluation for run in members):
        return []
    found = [{it.facts.after // every * every: it.whole for it in run.before} for run in members]
    last = [run.evaluation.whole for run in members if run.evaluation]
    in_all = set.intersection(*map(set, found))
    return [*((due, [of[due] for of in found]) for due in sorted(in_all)), (runs.steps, last)]


def _point(end: int, parts: Sequence[Part], measure: str, runs: Runs) -> Point:
    values = [part.behaviour.get(measure) for part in parts]
    episodes = min(part.episodes for part in parts) if runs.is_flag(measure) else None
    return mean_point(end, values, episodes, runs.bounds(measure))


def _return_point(end: int, parts: Sequence[Part], reward: str) -> Point:
    return mean_point(end, [part.returns.get(reward) for part in parts])
