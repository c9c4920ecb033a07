"""The trainings of one group, whatever left them: an arm's cells, recordings, or logs.

How they are compared, what a reward alone taught, and what each term of a reward paid: at the start of its trainings,
at their end, in the evaluations, and beside others. Of the return of an episode, what a proposed reward's trainings are
paid by it, minus what the baseline's trainings are paid by it, is the behaviour part of a change, on the path that
takes the ruler on the baseline's runs. As the return is the sum of its terms, so is that part: told term by term.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from harness.errors import Unscored
from harness.eta.behaviour_change import Quantity
from harness.eta.curve import GroupCurve, Kind, stream_curve
from harness.eta.headline import SUCCESS
from harness.eta.index import Estimate, mean_of_known
from harness.eta.interval import CONFIDENCE, SHARE, UNBOUNDED, Bounds, Side, difference_bounds, why_no_interval
from harness.eta.manner import TRAINING, WHOLE
from harness.eta.splits import Pair
from harness.files.plain import Plain, tells
from harness.results.by_term import ByTerm
from harness.results.cell_results import CellResults
from harness.results.comparison import Comparison, Group
from harness.results.learning import Learning, LearningCurve, Point, mean_point, stretches
from harness.results.metrics import Values, last_values
from harness.results.recordings.episodes import Part
from harness.results.recordings.runs import Run, Runs

LEARNED = Quantity(SUCCESS, "", "higher", TRAINING, 1, bounds=SHARE)
"""What is known of an arm's training: the share of its episodes that reached the target."""
KEPT_CURVES = 2
"""Many rewards are compared with one baseline, so that the curves that were read last are asked for again."""


Trained: TypeAlias = Run | CellResults
"""One training: what it was paid, and what it did. What is not known of its pay raises Unscored."""


class TermsOfTraining(NamedTuple):
    """What the terms of one reward paid one training."""

    training: ByTerm | None
    """In the training itself; None where it is not asked for."""
    evaluation: ByTerm | None
    """In the evaluation of its final policy; None where there is none."""

    def final(self, term: str) -> float | None:
        """What a term paid an episode of the evaluation, or where there is none of the end of the training."""
        told = self.evaluation or self.training
        found = told.terms.get(term) if told else None
        return None if found is None else found.whole if self.evaluation else found.end


@dataclass(frozen=True)
class Match:
    """The trainings of one comparison.

    Attributes:
        baseline: The label of the reward that the other one is compared with.
        proposed: The label of the other one; the same for the null control.
        one: The trainings by the baseline, by seed.
        other: Those by the other reward; of the null control the baseline's with other seeds.
        again: The baseline's trainings with other seeds, by the seed that they stand beside.
    """

    baseline: str
    proposed: str
    one: Mapping[int, Trained]
    other: Mapping[int, Trained]
    again: Mapping[int, Trained] = field(default_factory=dict)

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds that both have. What is paid is compared on them."""
        return tuple(sorted(self.one.keys() & self.other.keys()))

    @property
    def seeds_of(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """All seeds of each side, those of both first; the null control has no others. Behaviour is compared on all."""
        one, other = ((*self.seeds, *sorted(it.keys() - {*self.seeds})) for it in (self.one, self.other))
        return (self.seeds, self.seeds) if self.baseline == self.proposed else (one, other)

    @property
    def sides(self) -> tuple[list[Trained], list[Trained]]:
        """The trainings of `seeds_of`."""
        one, other = self.seeds_of
        return [self.one[seed] for seed in one], [self.other[seed] for seed in other]

    @property
    def recorded(self) -> list[Run]:
        """The recordings and logs among the trainings of both sides."""
        return [it for side in self.sides for it in side if isinstance(it, Run)]

    def of(self, who: str) -> list[Trained]:
        """The trainings of one side with the seeds that both have, ``baseline`` or ``proposed``."""
        side = self.one if who == "baseline" else self.other
        return [side[seed] for seed in self.seeds]

    @property
    def control(self) -> list[Trained]:
        """The baseline's trainings with other seeds, if there are some for all seeds."""
        return [self.again[seed] for seed in self.seeds] if self.again.keys() >= {*self.seeds} else []


@dataclass(frozen=True, eq=False)
class Trainings:
    """The trainings of one group.

    Attributes:
        group: What all of them share.
        baseline: The label of the reward that the others are compared with; it need not be among them.
        runs: The trainings by reward and seed, without those of the null control; rewards in their order.
        names: The names of the measures.
        quantity: What a measure is in the episodes of one manner, of which each training has so many at least.
        kind: Which curves the indices are read from; see `harness.eta.curve.GroupCurve`.
        deciding: The names of the measures that decide, in this order.
        leading: Those that are shown first.
        success: The name of the share of episodes by which learning is measured; empty if there is none.
        averaged: The final policy counts with the mean over so many of the last evaluations, at most.
        again: The baseline's trainings with other seeds, by the seed that they stand beside.
        is_alone: Whether one reward taught them, and nothing is to be compared with it.
        read: What was read of recordings and logs; None of an arm.
    """

    group: Group
    baseline: str
    runs: Mapping[tuple[str, int], Trained]
    names: Sequence[str]
    quantity: Callable[[str, str, int], Quantity]
    kind: Kind
    deciding: tuple[str, ...]
    leading: Sequence[str]
    success: str
    averaged: int
    again: Mapping[int, Trained]
    is_alone: bool
    read: Runs | None = None
    _curves: dict[tuple[Trained, ...], GroupCurve] = field(default_factory=dict)
    _learned: dict[tuple[bool, tuple[Trained, ...]], LearningCurve] = field(default_factory=dict)

    @property
    def rewards(self) -> list[str]:
        """The labels of the rewards that taught."""
        return list(dict.fromkeys(reward for reward, _ in self.runs))

    def members(self, reward: str) -> list[Trained]:
        """The trainings by a reward, in the order of their seeds."""
        return [self.runs[key] for key in sorted(self.runs) if key[0] == reward]

    def match(self, baseline: str, proposed: str) -> Match:
        """The trainings of one reward, and those of another one; of the baseline and itself the null control."""
        one, other = ({seed: it for (name, seed), it in self.runs.items() if name == of} for of in (baseline, proposed))
        again = self.again if baseline == self.baseline else {}
        return Match(baseline, proposed, one, again if baseline == proposed else other, again)

    def matches(self, *, pairs: bool) -> list[Match]:
        """Each reward that taught with the baseline, or with every one before it; the null control is last."""
        baseline, *others = self.rewards
        control = [(baseline, baseline)] if self.again else []
        asked = combinations(self.rewards, 2) if pairs else ((baseline, it) for it in others)
        return [self.match(*names) for names in (*asked, *control)]

    @property
    def number_of(self) -> Literal["returns", "indices"]:
        """What the sentence about the number tells. Only what it tells makes a claim, besides the indices."""
        return "returns" if self.read else "indices"

    def pay_name(self, reward: str) -> str:
        """What the pay of an episode is called in a curve."""
        return f"return paid by {reward}" if self.read else "return, as paid"

    # Behaviour

    def decided_in(self, episodes: Mapping[str, int]) -> str:
        """The manner that decides; empty for that of the cells."""
        return "" if not self.read else next((manner for manner in episodes if episodes[manner]), WHOLE)

    def last_of(self, run: Trained) -> Values:
        """Means over the last evaluations of a training; empty where only the final policy was evaluated."""
        is_evaluated = self.group.evaluate_every and self.averaged > 1
        return last_values(run.moments, self.group.steps, self.averaged) if is_evaluated else {}

    # Pay

    def curve(self, match: Match, pair: Pair) -> GroupCurve:
        """S_r(tau_q) of one pair (r, q).

        Raises:
            Unscored: It is not known what r pays these trainings.
        """
        by, members = match.of(pair[0])[0], match.of(pair[1])
        return self._curve(members) if pair[0] == pair[1] else self._paid(members, by)

    def control(self, match: Match) -> GroupCurve | None:
        """The curve of the baseline's trainings with other seeds."""
        return self._curve(match.control) if match.control else None

    def _curve(self, members: Sequence[Trained]) -> GroupCurve:
        """What trainings by one reward were paid by it."""
        key = tuple(members)
        found = self._curves.pop(key, None) or self._paid(members, members[0])
        self._curves[key] = found
        for old in list(self._curves)[:-KEPT_CURVES]:
            del self._curves[old]
        return found

    def _paid(self, members: Sequence[Trained], by: Trained) -> GroupCurve:
        """The curve of trainings as one reward pays them. Only one of them at a time is in memory."""
        return stream_curve((it.paid(by) for it in members), len(members), min(it.cut for it in members), self.kind)

    def terms(self, reward: str, trained: str) -> list[TermsOfTraining]:
        """What the terms of one reward pay the trainings by another one, or its own.

        Raises:
            Unscored: They cannot pay these.
        """
        by = self.members(reward)[0]
        return [TermsOfTraining(it.terms(by, "training"), it.terms(by, "evaluation")) for it in self.members(trained)]

    # Learning

    def learning(self, comparison: Comparison) -> Learning:
        """The learning curves of both rewards, each of which has a training."""
        both = zip((comparison.baseline, comparison.proposed), comparison.trained, strict=True)
        sides = [(reward, [self.runs[reward, seed] for seed in seeds]) for reward, seeds in both]
        curves = self.learned(sides)
        floor = sides[0][1][0].measured.random if self.read or curves[0].runs else {}
        return Learning(curves, {name: floor.get(name) for name in curves[0].points})

    def learned(self, sides: Collection[tuple[str, Sequence[Trained]]]) -> tuple[LearningCurve, ...]:
        """What trainings by some rewards came to over their steps.

        In their evaluations, where all of them were evaluated while they learned; else in stretches of the training.
        """
        every = self.group.evaluate_every
        ways = [[it.on_the_way(every) if every else {} for it in members] for _, members in sides]
        is_evaluated = all(way for of in ways for way in of)
        measures = [LEARNED]
        if is_evaluated or self.read:
            measures = [self.quantity(name, WHOLE, 1) for name in self.names]
        keys = [(is_evaluated, tuple(members)) for _, members in sides]
        for key, (reward, members), found in zip(keys, sides, ways, strict=True):
            if key not in self._learned:  # the baseline's stand beside each reward
                self._learned[key] = self._curve_of(reward, members, measures, found if is_evaluated else None)
        return tuple(self._learned[key] for key in keys)

    def _curve_of(
        self,
        reward: str,
        members: Sequence[Trained],
        measures: Sequence[Quantity],
        evaluated: Sequence[Mapping[int, tuple[int, Part]]] | None,
    ) -> LearningCurve:
        """The mean over trainings of each measure, and of what each reward pays, at all evaluations that were due."""
        if evaluated is None:
            ends = list(stretches(self.read.steps if self.read else self.group.steps))
            parts = [(end, [it.episodes.part(begin, end) for it in members]) for begin, end in ends]
            of = f"the episodes of the training that ended in one of {len(ends)} equal parts of its steps"
        else:
            dues = sorted(set.union(*map(set, evaluated)))
            told = [[way[due] for way in evaluated if due in way] for due in dues]
            parts = [(round(sum(after for after, _ in it) / len(it)), [part for _, part in it]) for it in told]
            counts = sorted({part.episodes for _, there in parts for part in there})
            of = (
                f"an evaluation of {' to '.join(map(str, counts[:1] + counts[1:][-1:]))} episode{'s' * (counts != [1])}"
            )

        def points(values: Sequence[list[float | None]], bounds: Bounds = UNBOUNDED) -> tuple[Point, ...]:
            told = zip(parts, values, strict=True)
            return tuple(mean_point(end, [*of, *[None] * (len(members) - len(of))], bounds) for (end, _), of in told)

        found = {
            it.name: points([[part.behaviour.get(it.name) for part in there] for _, there in parts], it.ends)
            for it in measures
        }
        for payer in self.read.rewards if self.read else (reward,):
            found[self.pay_name(payer)] = points([[part.returns.get(payer) for part in there] for _, there in parts])
        runs = {} if evaluated is None else {it.seed: it.moments for it in members}
        return LearningCurve(reward, of, runs, found)


@tells("name=measure.name", "unit=measure.unit", "start", "end", "evaluation", "random")
class Stages(NamedTuple):
    """One measure, or the pay of an episode: means over trainings."""

    measure: Quantity
    start: Estimate
    """Over the first tenth of the episodes of each training."""
    end: Estimate
    """Over the last tenth."""
    evaluation: Estimate
    """Over the evaluations of the final policies."""
    random: float | None
    """What random actions come to; None where it is not known."""


@tells("*group", "reward", "seeds", "return=paid", "behaviour", "learning_of=curve.of", "learning=points")
@dataclass(frozen=True, eq=False)
class Alone(Plain):
    """What one reward taught in a group of trainings in which there is no other.

    Attributes:
        group: What the trainings share.
        reward: Its label.
        seeds: Of its trainings.
        paid: What it paid an episode.
        behaviour: Every measure that is known, those that decide in a comparison first.
        learning: What was paid, and the first measure, over the training.
        shown: The names of both in it, the measure first.
    """

    group: Group
    reward: str
    seeds: tuple[int, ...]
    paid: Stages
    behaviour: tuple[Stages, ...]
    learning: Learning
    shown: tuple[str, ...]

    @property
    def curve(self) -> LearningCurve:
        """The only one."""
        return self.learning.curves[0]

    @property
    def points(self) -> dict[str, tuple[Point, ...]]:
        """Those of `shown`."""
        return {name: self.curve.points[name] for name in self.shown}


def _stages(
    measure: Quantity, ends: Sequence[tuple[Part | None, ...]], random: Part | None, reward: str = ""
) -> Stages:
    """The means of one measure over trainings, or of what a reward paid."""

    def value(part: Part | None) -> float | None:
        return part and (part.returns.get(reward) if reward else part.behaviour.get(measure.name))

    def mean(stage: Sequence[Part | None]) -> Estimate:
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
    curves, paid = trainings.learned([(reward, members)]), _stages(pay, ends, random, reward)
    shown = [name for name in (*first[:1], SUCCESS) if name in curves[0].points][:1]
    return Alone(
        trainings.group,
        reward,
        tuple(it.seed for it in members),
        paid,
        tuple(it for it in stages if any(of.value is not None for of in (it.start, it.end, it.evaluation))),
        Learning(curves, {it.measure.name: it.random for it in (paid, *stages)}),
        (*shown, pay.name),
    )


PATH = "behaviour under {reward}, the ruler on the episodes of {baseline}'s trainings"
NOTHING, LACKING = Estimate(None), "have none"


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
    start: Estimate
    end: Estimate
    evaluation: Estimate
    others: Estimate = NOTHING
    random: float | None = None
    behaviour: Estimate = NOTHING
    ruler: Estimate = NOTHING
    never: bool = False

    @property
    def final(self) -> Estimate:
        """`evaluation`, or where there is none `end`."""
        return self.evaluation if self.evaluation.value is not None else self.end

    @property
    def over_training(self) -> float | None:
        """How much the mean changed from the start of the trainings to their end."""
        return None if self.start.value is None or self.end.value is None else self.end.value - self.start.value


@tells(
    "*group", "reward", "trainings", "training_steps=steps", "terms", "never_paid=never", "paid_twice=twice", "missing"
)
@dataclass(frozen=True)
class TermsPaid(Plain):
    """What each term of one reward paid, in one group of trainings.

    Attributes:
        group: What the trainings share.
        reward: The label of the reward.
        baseline: That of the reward that it is compared with; empty where it is that itself, or alone.
        trainings: How many trainings it taught.
        steps: How many steps they have together.
        terms: In their order.
        missing: Why it is not known what the terms pay the baseline's trainings; empty where it is.
        twice: The term that is the sum of all others in every step of its trainings; empty where there is none.
    """

    group: Group
    reward: str
    baseline: str
    trainings: int
    steps: int
    terms: tuple[TermPaid, ...]
    missing: str = ""
    twice: str = ""

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
        return any(it.behaviour.value is not None for it in self.terms)

    @property
    def most_changed(self) -> TermPaid | None:
        """The term that changed most: beside the baseline's trainings, else over its own; None where none changed."""
        known = [
            (abs(change), it)
            for it in self.terms
            if (change := it.behaviour.value if self.is_compared else it.over_training)
        ]
        return max(known, key=lambda pair: pair[0])[1] if known else None

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        most = self.most_changed
        return {
            **super().to_json(),
            "baseline": self.baseline or None,
            "path": self.path if self.is_compared else None,
            "most_changed": most and most.name,
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
    if not terms:
        return None
    twice = {it.twice for it in trained}
    told = twice.pop() if len(twice) == 1 else ""
    return TermsPaid(group, *names, len(own), sum(it.steps for it in trained), terms, missing, told)


def _difference(less: Sequence[float | None], from_: Sequence[float | None]) -> Estimate:
    """The mean of one side minus that of another, which are not paired; none where a training has no value."""
    one, other = ([value for value in side if value is not None] for side in (less, from_))
    if not one or not other or len(one) + len(other) < len(less) + len(from_):
        return NOTHING
    mean, seeds = sum(other) / len(other) - sum(one) / len(one), min(len(one), len(other))
    if notes := why_no_interval(seeds):
        return Estimate(mean, seeds=seeds, notes=notes)
    before, after = (Side([np.array(it)], [UNBOUNDED]) for it in (one, other))
    low, high = difference_bounds(before, after, CONFIDENCE)
    return Estimate(mean, low, high, seeds)


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
