"""One reward alone: what it paid, and what its policies did, without a word of better or worse."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from harness.eta.behaviour_change import TRAINING, Quantity
from harness.eta.headline import DECIDING
from harness.eta.seed_mean import SeedMean, mean_over_seeds
from harness.record.cell import Cell
from harness.record.folder import EVALUATION, RANDOM
from harness.results.cell_results import PAID
from harness.results.comparison import Group
from harness.results.learning import LearningCurve, curve_of_training
from harness.results.measured import Values
from harness.results.metrics import measure_of
from harness.results.records import Records

NO_BETTER = ""
"""In place of the direction of a measure that has none: pay."""


class Stages(NamedTuple):
    """One measure, or the pay of an episode: means over trainings."""

    measure: Quantity
    start: SeedMean
    """Over the first tenth of the episodes of each training."""
    end: SeedMean
    """Over the last tenth."""
    evaluation: SeedMean
    """Over the evaluations of the final policies."""
    random: float | None
    """What random actions come to; None where it is not known."""

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        told = {name: getattr(self, name).to_json() for name in ("start", "end", "evaluation")}
        return {"name": self.measure.name, "unit": self.measure.unit, **told, "random": self.random}


@dataclass(frozen=True, eq=False)
class Alone:
    """What one reward taught in a group of trainings in which there is no other.

    Attributes:
        group: What the trainings share.
        reward: Its label.
        seeds: Of its trainings.
        paid: What it paid an episode.
        behaviour: Every measure that is known, those that decide in a comparison first.
        curve: What was paid, and the first measure, over the training.
        shown: The names of both in `curve`, the measure first.
    """

    group: Group
    reward: str
    seeds: tuple[int, ...]
    paid: Stages
    behaviour: tuple[Stages, ...]
    curve: LearningCurve
    shown: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            **self.group.to_json(),
            "reward": self.reward,
            "seeds": list(self.seeds),
            "return": self.paid.to_json(),
            "behaviour": [it.to_json() for it in self.behaviour],
            "learning": {
                name: [{"steps": point.steps, **point.value.to_json()} for point in self.curve.points[name]]
                for name in self.shown
            },
        }


class OfTraining(NamedTuple):
    """What one training was paid, and what its policy did, by name."""

    start: Mapping[str, float | None]
    end: Mapping[str, float | None]
    evaluation: Mapping[str, float | None]
    episodes: tuple[int, int]
    """How many episodes start and end rest on each, and how many the evaluation."""


def stages_of(measure: Quantity, trainings: Sequence[OfTraining], random: float | None) -> Stages:
    """The means of one measure over trainings.

    Args:
        measure: What is measured; a share of episodes where its number of them is told.
        trainings: Of each seed.
        random: What random actions came to.
    """
    of_part, of_evaluation = (min((it.episodes[at] for it in trainings), default=0) for at in (0, 1))

    def mean(stage: str, episodes: int) -> SeedMean:
        values = [getattr(it, stage).get(measure.name) for it in trainings]
        known = [value for value in values if value is not None]
        missing = None if len(known) == len(values) else f"{len(values) - len(known)} of {len(values)} have none"
        is_share = measure.episodes is not None and episodes > 0
        return mean_over_seeds(known, missing, episodes if is_share else None, measure.bounds)

    return Stages(measure, mean("start", of_part), mean("end", of_part), mean("evaluation", of_evaluation), random)


def is_known(stages: Stages) -> bool:
    """Whether a measure has a value anywhere."""
    return any(it.mean is not None for it in (stages.start, stages.end, stages.evaluation))


# The cells of an arm


def alone_in(records: Records) -> tuple[Alone, ...]:
    """What each reward did that no other stands beside, of all groups of done cells.

    Raises:
        SchemaError: A file is damaged or written by a newer version.
    """
    planned: dict[Group, set[str]] = {}
    for manifest in records.manifests:
        if manifest.status != "skipped":
            planned.setdefault(Group.of(manifest.cell), set()).add(manifest.cell.reward.label)
    if records.plan.control:
        return ()
    return tuple(_alone(records, group, cells) for group, cells in records.groups.items() if len(planned[group]) == 1)


def _alone(records: Records, group: Group, cells: Sequence[Cell]) -> Alone:
    ordered = sorted(cells, key=lambda cell: cell.seed)
    trainings = [_training(records, cell) for cell in ordered]
    manifest = records.manifest(ordered[0])
    random: Values = records.measured(ordered[0]).random
    first = records.named or DECIDING
    names = sorted(records.metrics, key=lambda name: first.index(name) if name in first else len(first))
    measures = [measure_of(name, records.metrics[name], TRAINING, trainings[0].episodes[1], manifest) for name in names]
    found = [stages_of(measure, trainings, random.get(measure.name)) for measure in measures]
    pay = Quantity(PAID, "", NO_BETTER, TRAINING)
    curve = curve_of_training(records, group, ordered[0].reward.label, ordered)
    return Alone(
        group,
        ordered[0].reward.label,
        tuple(cell.seed for cell in ordered),
        stages_of(pay, trainings, _random_return(records, ordered[0])),
        tuple(filter(is_known, found)),
        curve,
        tuple(curve.points),
    )


def _training(records: Records, cell: Cell) -> OfTraining:
    found = records.of(cell)
    start, end, count = found.ends()
    measured = records.measured(cell)
    evaluated = {**measured.own, PAID: found.recorded_return(EVALUATION)}
    found.finish()
    return OfTraining(start, end, evaluated, (count, next(iter(measured.episodes.values()))))


def _random_return(records: Records, cell: Cell) -> float | None:
    """What the reward pays random actions, where a cell of its own recorded them."""
    owner = records.floor_of(cell)
    if owner is None or owner.reward != cell.reward:
        return None
    found = records.of(owner)
    value = found.recorded_return(RANDOM)
    found.finish()
    return value
