"""What each term of a reward paid: at the start of its trainings, at their end, in the evaluations, and beside others.

Of the return of an episode, what a proposed reward's trainings are paid by it, minus what the baseline's trainings are
paid by it, is the behaviour part of a change, on the path that takes the ruler on the baseline's runs. As the return is
the sum of its terms, so is that part: here it is told term by term.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from harness.errors import Unscored
from harness.eta.index import SeedMean, mean_of_known
from harness.eta.interval import CONFIDENCE, UNBOUNDED, difference_bounds, why_no_interval
from harness.files.plain import Plain
from harness.results.by_term import ByTerm
from harness.results.comparison import Group
from harness.results.trainings import TermsOfTraining, Trainings

PATH = "behaviour under {reward}, the ruler on the episodes of {baseline}'s trainings"
NOTHING, LACKING = SeedMean(None), "have none"


@dataclass(frozen=True)
class TermPaid(Plain):
    """What one term paid an episode. Means over trainings, with their 95 % intervals.

    Attributes:
        name: Of the term.
        start: Of the first tenth of the episodes of the reward's own trainings.
        end: Of the last tenth.
        evaluation: Of the evaluations of the final policies.
        others: Of the evaluations of the policies that the baseline trained; where none are recorded of the end of
            these trainings.
        random: Of random actions; None where they are not recorded, or cannot be paid.
        behaviour: `final` - `others`, the part that the term has in the behaviour part of the change.
        ruler: What it pays the baseline's evaluations minus what the baseline's own term of this name pays them.
        never: Whether it paid 0 in every recorded step of the reward's trainings.
    """

    name: str
    start: SeedMean
    end: SeedMean
    evaluation: SeedMean
    others: SeedMean = NOTHING
    random: float | None = None
    behaviour: SeedMean = NOTHING
    ruler: SeedMean = NOTHING
    never: bool = False

    @property
    def final(self) -> SeedMean:
        """`evaluation`, or where there is none `end`."""
        return self.evaluation if self.evaluation.mean is not None else self.end

    @property
    def over_training(self) -> float | None:
        """How much the mean changed from the start of the trainings to their end."""
        return None if self.start.mean is None or self.end.mean is None else self.end.mean - self.start.mean


@dataclass(frozen=True)
class TermsPaid:
    """What each term of one reward paid, in one group of trainings.

    Attributes:
        group: What the trainings share.
        reward: The label of the reward.
        baseline: That of the reward that it is compared with; empty where it is that itself, or alone.
        trainings: How many trainings it taught.
        steps: How many steps they have together.
        terms: In their order.
        missing: Why it is not known what the terms pay the baseline's trainings; empty where it is.
    """

    group: Group
    reward: str
    baseline: str
    trainings: int
    steps: int
    terms: tuple[TermPaid, ...]
    missing: str = ""

    @property
    def path(self) -> str:
        """On which of the two paths of a split the behaviour of the terms adds up; see `harness.eta.splits`."""
        return PATH.format(reward=self.reward, baseline=self.baseline)

    @property
    def never(self) -> tuple[str, ...]:
        """The terms that never paid."""
        return tuple(it.name for it in self.terms if it.never)

    @property
    def is_compared(self) -> bool:
        """Whether it is known what the terms pay the baseline's trainings."""
        return any(it.behaviour.mean is not None for it in self.terms)

    @property
    def most_changed(self) -> TermPaid | None:
        """The term that changed most: beside the baseline's trainings, else over its own; None where none changed."""
        known = [
            (abs(change), it)
            for it in self.terms
            if (change := it.behaviour.mean if self.is_compared else it.over_training)
        ]
        return max(known, key=lambda pair: pair[0])[1] if known else None

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        most = self.most_changed
        return {
            **self.group.to_json(),
            "reward": self.reward,
            "baseline": self.baseline or None,
            "trainings": self.trainings,
            "training_steps": self.steps,
            "terms": [it.to_json() for it in self.terms],
            "path": self.path if self.is_compared else None,
            "most_changed": most and most.name,
            "never_paid": list(self.never),
            "missing": self.missing,
        }


def terms_paid(
    group: Group,
    names: tuple[str, str],
    own: Sequence[TermsOfTraining],
    others: Sequence[TermsOfTraining] = (),
    ours: Sequence[TermsOfTraining] = (),
    random: ByTerm | None = None,
    missing: str = "",
) -> TermsPaid | None:
    """What each term of a reward paid; None of a reward without terms.

    Args:
        group: What the trainings share.
        names: The label of the reward, and of the baseline; the latter empty where there is none.
        own: What its terms paid each of its own trainings.
        others: What its terms pay each of the baseline's trainings.
        ours: What the baseline's own terms paid each of the baseline's trainings.
        random: What its terms pay random actions.
        missing: Why there are no `others`.
    """
    trained = [it.training for it in own if it.training is not None]

    def paid(name: str) -> TermPaid:
        before, after, ruled = ([it.final(name) for it in side] for side in (others, own, ours))
        stages = [it.training.terms.get(name) if it.training is not None else None for it in own]
        acted = random.terms.get(name) if random is not None else None
        return TermPaid(
            name,
            mean_of_known([it.start if it else None for it in stages], LACKING),
            mean_of_known([it.end if it else None for it in stages], LACKING),
            mean_of_known(after, LACKING) if all(it.evaluation for it in own) else NOTHING,
            mean_of_known(before, LACKING) if others else NOTHING,
            acted.whole if acted is not None else None,
            _difference(before, after),
            _difference(ruled, before),
            not any(it and it.pays for it in stages),
        )

    terms = tuple(map(paid, dict.fromkeys(name for it in trained for name in it.terms)))
    return TermsPaid(group, *names, len(own), sum(it.steps for it in trained), terms, missing) if terms else None


def _difference(less: Sequence[float | None], from_: Sequence[float | None]) -> SeedMean:
    """The mean of one side minus that of another, which are not paired; none where a training has no value."""
    one, other = ([value for value in side if value is not None] for side in (less, from_))
    if not one or not other or len(one) + len(other) < len(less) + len(from_):
        return NOTHING
    mean, seeds = sum(other) / len(other) - sum(one) / len(one), min(len(one), len(other))
    if notes := why_no_interval(seeds):
        return SeedMean(mean, seeds=seeds, notes=notes)
    low, high = difference_bounds([np.array(one)], [np.array(other)], [UNBOUNDED], CONFIDENCE)
    return SeedMean(mean, low, high, seeds)


def terms_of(trainings: Trainings) -> Iterator[TermsPaid]:
    """What each term paid, of each reward of these trainings that has terms.

    Raises:
        SchemaError: A file is damaged or written by a newer version.
    """
    baseline = trainings.baseline
    having = [name for name in trainings.rewards if any(it.has_terms for it in trainings.members(name))]
    for reward in having:
        is_beside, missing = reward != baseline and baseline in trainings.rewards, ""
        own, first = trainings.terms(reward, reward), trainings.members(reward)[0]
        try:
            others = trainings.terms(reward, baseline) if is_beside else []
        except Unscored as unscored:
            others, missing = [], str(unscored)
        ours = trainings.terms(baseline, baseline) if is_beside and baseline in having else []
        names, random = (reward, baseline if is_beside else ""), first.terms(first, "random")
        yield from filter(None, [terms_paid(trainings.group, names, own, others, ours, random, missing)])
