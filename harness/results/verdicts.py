"""The verdicts of an experiment: its questions, asked together, and their answers put beside each comparison.

A question is whether one reward makes the robot behave better than the baseline with one budget of training, over all
places where both trained. Whatever else the comparisons say are hints, corrected by themselves.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import takewhile, zip_longest

import numpy as np
from threadpoolctl import threadpool_limits

from harness.eta.behaviour_change import Change, question_of, seeds_of, size_of, together
from harness.eta.verdict.looks import Looks, rule_in_looks
from harness.eta.verdict.question import Question
from harness.eta.verdict.ruling import Ruling, better_in, opposed_in, rule, rule_places
from harness.record.cell import Cell, Manifest
from harness.record.terms import FIRST, Terms
from harness.results.comparison import Comparison, Group, correct
from harness.results.pool import Pool

UNKNOWN = math.inf
"""How many trainings are missing where nobody knows."""


def missing_text(missing: float) -> str:
    """A clause that so many trainings are missing; empty where none is."""
    if missing == UNKNOWN:
        return "nobody knows how many trainings are missing"
    return f"{missing:,} training{'s are' if missing != 1 else ' is'} missing" if missing else ""


LookOf = Callable[[Comparison], tuple[Mapping[int, int], int]]
"""Tells of a comparison the look at which each seed was trained, and how many looks are complete."""


@dataclass(frozen=True, eq=False)
class Asked:
    """One question: the comparisons that it is about, and what the test takes from them."""

    members: tuple[Comparison, ...]
    changes: tuple[tuple[Change, ...], ...]
    """By place, the measures that decide, the same in each."""
    offered: tuple[tuple[Change, ...], ...] = ()
    """By place, those that could have been named to decide instead; none where it was named before."""

    @cached_property
    def question(self) -> Question:
        """The values, scaled so that higher is better and places can be put together; those that decide come first."""
        # Higher is better; what is no share counts relative to its size, so that places can be put together.
        each = [(*of, *more) for of, more in zip_longest(self.changes, self.offered, fillvalue=())]
        scales = [[(-1.0 if it.measure.better == "lower" else 1.0) / size_of(it) for it in of] for of in each]
        return question_of(each, scales)

    def together(self, confidence: float) -> tuple[Change, ...]:
        """The measures, means over places, with intervals of this confidence; none where places have other ones."""
        of_measures = list(zip(*self.changes, strict=True))
        if any(len({it.name for it in of_places}) > 1 for of_places in of_measures):
            return ()
        return tuple(together(of_places, confidence) for of_places in of_measures)


def with_verdicts(
    found: Sequence[Comparison], terms: Terms = FIRST, look_of: LookOf | None = None, to_come: float = 0
) -> tuple[Comparison, ...]:
    """Comparisons, in their order, with the answers and with hints whose p-values hold for all of them together.

    A null control makes no claim about rewards. So it is ruled by itself, and makes no other p-value larger.

    Args:
        found: All comparisons of an experiment.
        terms: What was agreed on before the first training.
        look_of: In an experiment with looks: tells them.
        to_come: In one without looks: how many trainings are missing. Without them nothing is tested: how they end is
            an outcome too, and whoever looks again and again gives luck more chances.
    """
    of_rewards = [it for it in found if not it.is_control]
    to_come = 0 if terms.looks else to_come
    with threadpool_limits(1):  # the matrices are small: a second thread mostly waits, at the cost of a core
        ruled = iter(_ruled(of_rewards, terms, look_of, to_come))
        return tuple(_ruled([it], terms, None, to_come)[0] if it.is_control else next(ruled) for it in found)


def _ruled(family: Sequence[Comparison], terms: Terms, look_of: LookOf | None, to_come: float) -> list[Comparison]:
    """Each comparison with its own ruling and, where there are several places, with the answer over all of them."""
    asked = _asked(family)
    unasked = Ruling(asked=len(asked), missing=missing_text(to_come))
    if terms.looks and look_of is not None:
        rulings = [_in_looks(it, terms, look_of) for it in asked]
    elif to_come:
        rulings = [unasked] * len(asked)
    else:
        offered = [len(it.offered[0]) if it.offered else 0 for it in asked]
        ruled = rule([it.question for it in asked], 1 + len(terms.grown), offered)
        rulings = [replace(it, grown=terms.grown) for it in ruled]
    found = dict[int, tuple[Sequence[Change], Ruling, Pool | None]]()
    for it, whole in zip(asked, rulings, strict=True):
        pool, of_places = _pooled(it, whole) if len(it.members) > 1 else (None, [whole])
        for member, changes, ruling in zip(it.members, it.changes, of_places, strict=True):
            found[id(member)] = (changes, ruling, pool)
    return list(correct([it.with_ruling(*found.get(id(it), ((), unasked, None))) for it in family]))


def _in_looks(asked: Asked, terms: Terms, look_of: LookOf) -> Ruling:
    """What the test says at the looks that are complete in all places."""
    told = [look_of(it) for it in asked.members]
    complete = min(count for _, count in told)
    looks = Looks(terms.looks, terms.asked, terms.margin)
    at = [[of_seed.get(seed, len(terms.looks)) for of_seed, _ in told] for seed in seeds_of(asked.changes)]
    return rule_in_looks(asked.question, np.array(at), looks, complete)


def _pooled(asked: Asked, whole: Ruling) -> tuple[Pool, Sequence[Ruling]]:
    """The answer over all places of a question, and what the test says of each."""
    question, first = asked.question, asked.members[0]
    is_tested = bool(whole.signs)
    of_places = rule_places(question, whole) if is_tested else [whole] * len(asked.members)
    pool = Pool(
        first.names,
        first.group.steps,
        tuple(" · ".join(member.group.labels.values()) for member in asked.members),
        whole,
        asked.together(whole.confidence),
        better_in(question, whole) if is_tested else 0,
        opposed_in(whole, of_places),
        first.group.subject,
    )
    return pool, of_places


def _asked(family: Iterable[Comparison]) -> list[Asked]:
    """The questions; a comparison without a value of what decides has none."""
    found: dict[tuple[str, str, int], list[Comparison]] = {}
    for it in family:
        if it.decisive_changes:
            found.setdefault((it.baseline, it.proposed, it.group.steps), []).append(it)
    asked = (
        Asked(
            tuple(members),
            _in_all([it.decisive_changes for it in members]) or tuple(it.decisive_changes[:1] for it in members),
            _in_all([it.offered_changes for it in members]),
        )
        for members in found.values()
    )
    return [it for it in asked if it.changes[0]]


def _in_all(of_places: Sequence[Sequence[Change]]) -> tuple[tuple[Change, ...], ...]:
    """By place, the measures that all places have; nothing where they share none."""
    # What a measure is whatever the manner in its place: success at the end, or success while training.
    kinds = [[(change.name, change.measure.is_while_training) for change in changes] for changes in of_places]
    shared = [kind for kind in kinds[0] if all(kind in others for others in kinds)]
    each = (tuple(changes[of.index(kind)] for kind in shared) for changes, of in zip(of_places, kinds, strict=True))
    return tuple(each) if shared else ()


ENDED = ("done", "failed", "damaged", "skipped")
COUNTED, LOST = ("done", "skipped", "not needed"), ("failed", "damaged")
"""How cells end that no answer waits for. How one ends that failed is an outcome too, which nobody measured."""


@dataclass(frozen=True, eq=False)
class Seen:
    """The trainings of an experiment that a plan divides into looks.

    The seeds of a place come in the order of the plan: those of the first look first.

    Attributes:
        looks: Seeds of each reward in each place at each look, increasing.
        status: How each cell ended, by group and reward, in the order of the plan.
    """

    looks: Sequence[int]
    status: Mapping[tuple[Group, str], Mapping[Cell, str]]

    @classmethod
    def of(cls, manifests: Sequence[Manifest], looks: Sequence[int]) -> "Seen":
        """What manifests tell, in the order of the plan."""
        found: dict[tuple[Group, str], dict[Cell, str]] = {}
        for it in manifests:
            found.setdefault((Group.of(it.cell), it.cell.reward.label), {})[it.cell] = it.status
        return cls(looks, found)

    @property
    def to_come(self) -> int:
        """How many trainings are missing: they have not ended, failed, or left files that cannot be read.

        A plan to the end counts those that ended, however they did: whoever fails does not hold it up for ever.
        """
        counted = (*COUNTED, *LOST) if self.looks else COUNTED
        return sum(status not in counted for cells in self.status.values() for status in cells.values())

    def lost(self, group: Group, reward: str) -> tuple[int, ...]:
        """In a plan to the end, the seeds of a reward's trainings that failed or cannot be read."""
        cells = self.status.get((group, reward), {}) if self.looks else {}
        return tuple(cell.seed for cell, status in cells.items() if status in LOST)

    @property
    def groups(self) -> tuple[Group, ...]:
        """The places."""
        return tuple(dict.fromkeys(group for group, _ in self.status))

    def look_of(self, comparison: Comparison) -> tuple[Mapping[int, int], int]:
        """The look of each seed, counted from 0, and how many looks are complete under both rewards."""
        cells = self.status.get((comparison.group, comparison.baseline), {})
        of_seed = {cell.seed: sum(at >= end for end in self.looks) for at, cell in enumerate(cells)}
        rewards = (comparison.baseline, comparison.proposed)
        return of_seed, min(self.complete(reward, [comparison.group]) for reward in rewards)

    def complete(self, reward: str, groups: Iterable[Group] | None = None) -> int:
        """How many looks are complete for a reward: all of their cells have ended, in all places."""
        there = [self.status.get((group, reward), {}) for group in (self.groups if groups is None else groups)]
        ended = [sum(1 for _ in takewhile(ENDED.__contains__, cells.values())) for cells in there]
        return sum(min(ended, default=0) >= end for end in self.looks)

    def cells_of(self, rewards: Iterable[str], look: int) -> list[Cell]:
        """The cells of some rewards up to a look, counted from 0, in the order of the plan within each place."""
        wanted = set(rewards)
        return [
            cell
            for (_, reward), cells in self.status.items()
            if reward in wanted
            for cell in list(cells)[: self.looks[look]]
        ]
