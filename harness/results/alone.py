"""One reward alone: what it paid, and what its policies did, without a word of better or worse."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from harness.eta.behaviour_change import Quantity
from harness.eta.headline import SUCCESS
from harness.eta.index import SeedMean, mean_of_known
from harness.eta.manner import TRAINING
from harness.results.comparison import Group
from harness.results.learning import LearningCurve
from harness.results.recordings.episodes import Part
from harness.results.trainings import Trainings


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
            "learning": {name: [point.to_json() for point in self.curve.points[name]] for name in self.shown},
        }


def _stages(
    measure: Quantity, ends: Sequence[tuple[Part | None, ...]], random: Part | None, reward: str = ""
) -> Stages:
    """The means of one measure over trainings, or of what a reward paid."""

    def value(part: Part | None) -> float | None:
        return part and (part.returns.get(reward) if reward else part.behaviour.get(measure.name))

    def mean(stage: Sequence[Part | None]) -> SeedMean:
        return mean_of_known(list(map(value, stage)), "have none", measure.ends)

    start, end, evaluation = map(mean, zip(*ends, strict=True))
    return Stages(measure, start, end, evaluation, value(random))


def alone_of(trainings: Trainings) -> Alone | None:
    """What the only reward of these trainings did; None where another one, or a null control, stands beside it.

    Raises:
        SchemaError: A file is damaged or written by a newer version.
    """
    if not trainings.is_alone:
        return None
    (reward,) = trainings.rewards
    members, pay = trainings.members(reward), Quantity(trainings.pay_name(reward), "", "", TRAINING)
    ends, random = [it.ends() for it in members], members[0].at_random()
    first = trainings.leading
    names = dict.fromkeys([*(name for name in first if name in trainings.names), *trainings.names])
    evaluated = ends[0][2].episodes if ends[0][2] else 0
    stages = [_stages(trainings.quantity(name, TRAINING, evaluated), ends, random) for name in names]
    curve = trainings.learned(reward, members)
    shown = [name for name in (*first[:1], SUCCESS) if name in curve.points][:1]
    return Alone(
        trainings.group,
        reward,
        tuple(it.seed for it in members),
        _stages(pay, ends, random, reward),
        tuple(it for it in stages if any(of.mean is not None for of in (it.start, it.end, it.evaluation))),
        curve,
        (*shown, pay.name),
    )
