"""The verdicts of an experiment: its questions, asked together, and their answers put beside each comparison.

A question is whether one reward makes the robot behave better than the baseline with one budget of training, over all
places where both trained. Whatever else the comparisons say are hints, corrected by themselves.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from harness.arrays import Float
from harness.eta.behaviour_change import Change
from harness.eta.interval import SHARE, Bounds
from harness.eta.verdict.looks import Looks, rule_in_looks
from harness.eta.verdict.question import Question
from harness.eta.verdict.ruling import LEVEL, Ruling, better_in, rule, rule_alone, rule_places
from harness.eta.verdict.together import Together
from harness.record.terms import FIRST, Terms
from harness.results.comparison import Comparison, Group, correct
from harness.results.pool import Pool

SPEED_LEVEL = 0.01
"""What the second question, whether the robot learns faster, takes of the 5 %."""
RACED = "The race decides, and ends a reward's trainings when it leaves; this comparison by itself is no test."
LookOf = Callable[[Comparison], tuple[Mapping[int, int], int]]
"""Tells of a comparison the look at which each seed was trained, and how many looks are complete."""
Place = tuple[Group, str, str]
"""What tells a comparison apart, see `Comparison.place_key`."""


class Key(NamedTuple):
    """What a question is about."""

    baseline: str
    proposed: str
    steps: int


@dataclass(frozen=True, eq=False)
class Asked:
    """One question: the comparisons that it is about, and what the test takes from them."""

    key: Key
    members: tuple[Comparison, ...]
    changes: tuple[tuple[Change, ...], ...]
    """By place, the measures that decide, as many in each."""

    @property
    def question(self) -> Question:
        """Higher is better; what is no share counts relative to its size, so that places can be put together."""
        scales = [[_scale_of(change) for change in changes] for changes in self.changes]
        return _question(self.changes, np.array(scales, dtype=np.float64))

    def together(self) -> tuple[Together, ...]:
        """The measures, means over places; none where units or episodes differ."""
        found = []
        for of_places in zip(*self.changes, strict=True):
            if len({(it.name, it.measure.unit) for it in of_places}) > 1:
                return ()
            columns = tuple((change,) for change in of_places)
            found.append(Together(of_places[0].measure, _question(columns, np.ones((len(columns), 1)))))
        return tuple(found)


def with_verdicts(
    found: Sequence[Comparison], terms: Terms = FIRST, look_of: LookOf | None = None
) -> tuple[Comparison, ...]:
    """Comparisons, in their order, with the answers and with hints whose p-values hold for all of them together.

    A null control makes no claim about rewards. So it is ruled by itself, and makes no other p-value larger.

    Args:
        found: All comparisons of an experiment.
        terms: What was agreed on before the first training.
        look_of: In an experiment with looks: tells them.
    """
    of_rewards = [it for it in found if not it.is_control]
    with threadpool_limits(1):  # the matrices are small: a second thread mostly waits, at the cost of a core
        ruled = iter(_ruled(of_rewards, terms, look_of))
        return tuple(_ruled([it], terms, None)[0] if it.is_control else next(ruled) for it in found)


def _ruled(family: Sequence[Comparison], terms: Terms, look_of: LookOf | None) -> list[Comparison]:
    asks_speed = terms.asks_speed and any(it.speed is not None for it in family)
    level = LEVEL - SPEED_LEVEL if asks_speed else LEVEL
    asked = _asked(family, lambda it: it.decisive_changes)
    if terms.race:
        rulings = {it.key: Ruling(level=level, asked=len(asked), instead=RACED) for it in asked}
    elif terms.looks and look_of is not None:
        rulings = {it.key: _in_looks(it, terms, look_of) for it in asked}
    else:
        rulings = _at_once(asked, level)
    answered = _with_rulings(family, asked, rulings, level)
    if asks_speed:
        speeds = _asked(family, lambda it: () if it.speed is None else (it.speed,))
        answered = _with_speeds(answered, speeds, _at_once(speeds, SPEED_LEVEL))
    return list(correct(answered))


def _at_once(asked: Sequence[Asked], level: float) -> dict[Key, Ruling]:
    """What the test says of each question over all of its places."""
    questions = [it.question for it in asked]
    if all(len(it.members) == 1 for it in asked):
        rulings = rule(questions, level)
    else:
        rulings = [rule_alone(question, len(asked), level) for question in questions]
    return {it.key: ruling for it, ruling in zip(asked, rulings, strict=True)}


def _in_looks(asked: Asked, terms: Terms, look_of: LookOf) -> Ruling:
    """What the test says at the looks that are complete in all places."""
    told = [look_of(it) for it in asked.members]
    complete = min(count for _, count in told)
    looks = Looks(terms.looks, terms.asked, terms.margin)
    question = asked.question
    seeds = _seeds_of(asked.changes)
    at = np.full((len(seeds), len(asked.members)), len(terms.looks), np.int64)
    for place, (of_seed, _) in enumerate(told):
        for row, seed in enumerate(seeds):
            at[row, place] = of_seed.get(seed, len(terms.looks))
    firsts = [of_place[0] for of_place in asked.changes]
    ends = [ends_of(change, _scale_of(change)) for change in firsts]
    return rule_in_looks(replace(question, looks=at), looks, complete, ends)


def _with_rulings(
    family: Sequence[Comparison], asked: Sequence[Asked], rulings: Mapping[Key, Ruling], level: float
) -> list[Comparison]:
    """Each comparison with its own ruling and, where there are several places, with the answer over all of them."""
    found = dict[Place, tuple[Ruling, Pool | None]]()
    for it in asked:
        whole = rulings[it.key]
        if len(it.members) == 1:
            found[it.members[0].place_key] = (whole, None)
            continue
        question = it.question
        pool = Pool(
            it.members[0].names,
            it.key.steps,
            tuple(member.group.title for member in it.members),
            whole,
            it.together(),
            better_in(question, whole) if question.is_testable else 0,
            it.members[0].group.subject,
        )
        of_places = [whole] * len(it.members) if whole.instead else rule_places(question, whole)
        for member, ruling in zip(it.members, of_places, strict=True):
            found[member.place_key] = (ruling, pool)
    nothing = (Ruling(level=level, asked=len(asked)), None)
    return [it.with_ruling(*found.get(it.place_key, nothing)) for it in family]


def _with_speeds(
    family: Sequence[Comparison], asked: Sequence[Asked], rulings: Mapping[Key, Ruling]
) -> list[Comparison]:
    found = dict[Place, Ruling]()
    for it in asked:
        whole = rulings[it.key]
        places = [whole] if len(it.members) == 1 else rule_places(it.question, whole)
        found |= {member.place_key: ruling for member, ruling in zip(it.members, places, strict=True)}
    return [it.with_speed(found[it.place_key]) if it.place_key in found else it for it in family]


def _asked(family: Iterable[Comparison], changes_of: Callable[[Comparison], Sequence[Change]]) -> list[Asked]:
    """The questions; a comparison without a value of what decides has none."""
    found: dict[Key, list[Comparison]] = {}
    for it in family:
        if changes_of(it):
            found.setdefault(Key(it.baseline, it.proposed, it.group.steps), []).append(it)
    asked = []
    for key, members in found.items():
        count = min(len(changes_of(it)) for it in members)
        asked.append(Asked(key, tuple(members), tuple(tuple(changes_of(it)[:count]) for it in members)))
    return asked


def _scale_of(change: Change) -> float:
    """1 for a measure of which more is better, -1 for one of which less is; divided by its size if it is no share."""
    sign = 1.0 if change.measure.better == "higher" else -1.0
    if change.measure.episodes is not None or change.measure.bounds == SHARE:
        return sign
    size = float(np.mean(np.abs(change.values)))
    return sign / size if size > 0.0 else sign


def ends_of(change: Change, scale: float) -> Bounds:
    """What a value of a measure can be, times a scale."""
    low, high = sorted(scale * end for end in (SHARE if change.measure.episodes is not None else change.measure.bounds))
    return low, high


def _seeds_of(changes: Sequence[Sequence[Change]]) -> list[int]:
    return sorted({seed for of_place in changes for change in of_place for seed in change.of_seeds})


def _question(changes: Sequence[Sequence[Change]], scales: Float) -> Question:
    """The values of changes, by place and measure."""
    seeds = _seeds_of(changes)
    row = {seed: at for at, seed in enumerate(seeds)}
    values = np.full((2, len(seeds), *scales.shape), np.nan)
    for place, of_place in enumerate(changes):
        for measure, change in enumerate(of_place):
            at = [row[seed] for seed in change.of_seeds]
            values[:, at, place, measure] = np.transpose(change.values) * scales[place, measure]
    return Question.of(values)
