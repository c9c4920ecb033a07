"""One reward alone in an environment: what it paid, and what its policies did."""

from collections.abc import Mapping

from harness.eta.behaviour_change import TRAINING, Quantity
from harness.results.alone import NO_BETTER, Alone, OfTraining, is_known, stages_of
from harness.results.by_term import part_of
from harness.results.recordings.episodes import Part
from harness.results.recordings.learning import curve_of, return_name
from harness.results.recordings.runs import Run, Runs


def alone_of(runs: Runs) -> Alone | None:
    """What the only reward of these trainings did; None where another one, or a null control, stands beside it."""
    if len(runs.trained) != 1 or runs.control:
        return None
    (reward,) = runs.trained
    members, pay = runs.of(reward), Quantity(return_name(reward), "", NO_BETTER, TRAINING)
    trainings = [_training(run, reward) for run in members]
    random = _values(runs.random.whole, reward) if runs.random else {}
    measures = [runs.measure(name, TRAINING, trainings[0].episodes[1]) for name in runs.measures]
    return Alone(
        runs.group,
        reward,
        tuple(run.seed for run in members),
        stages_of(pay, trainings, random.get(pay.name)),
        tuple(filter(is_known, (stages_of(it, trainings, random.get(it.name)) for it in measures))),
        curve_of(runs, reward, members),
        (*runs.measures[:1], pay.name),
    )


def _training(run: Run, reward: str) -> OfTraining:
    last = run.episodes.last
    count = min(part_of(len(last)), len(last))
    start = run.episodes.part(0, int(last[count - 1]) + 1) if count else run.episodes.part(0, 0)
    end = run.episodes.part(int(last[-count]), int(last[-1]) + 1) if count else start
    evaluated = run.evaluation.whole if run.evaluation else None
    return OfTraining(
        _values(start, reward),
        _values(end, reward),
        {} if evaluated is None else _values(evaluated, reward),
        (count, evaluated.episodes if evaluated else 0),
    )


def _values(part: Part, reward: str) -> Mapping[str, float | None]:
    return {**part.behaviour, return_name(reward): part.returns.get(reward)}
