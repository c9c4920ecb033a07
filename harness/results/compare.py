"""Two rewards that trained in one group of cells, compared, and the verdicts of an experiment.

It is the same for traces of an arm and for recordings. A question is whether one reward makes the robot behave better
than the baseline with one budget of training, over all places where both trained. All questions of an experiment are
asked together, and their answers put beside each comparison. Whatever else the comparisons say are hints, corrected by
themselves.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import zip_longest
from typing import TypeAlias

import numpy as np
from threadpoolctl import threadpool_limits

from harness.errors import Unscored, UsageError
from harness.eta.behaviour_change import Change, Quantity, change_of, question_of, seeds_of, size_of, together
from harness.eta.curve import GroupCurve
from harness.eta.decomposition import decompose
from harness.eta.headline import PaidAtRandom, ReturnSplit, paid_at_random, split_returns
from harness.eta.interval import SHARE
from harness.eta.laws import ends_of
from harness.eta.manner import DETERMINISTIC, EVALUATION, LAST, LEARNING, OWN_AND_OTHER, STOCHASTIC, TRAINING
from harness.eta.splits import BB, BK, KB, KK, Decomposition, Pair
from harness.eta.swaps import Swaps, corrected_where_known, swaps_of
from harness.eta.verdict.looks import Looks, rule_in_looks
from harness.eta.verdict.question import Question
from harness.eta.verdict.ruling import Ruling, better_in, opposed_in, rule, rule_places
from harness.record.cell import KERNEL, Manifest
from harness.record.terms import FIRST, Terms
from harness.registry.spec import unknown_name
from harness.results.comparison import Behaviour, Comparison, Number, Seen, StepChange
from harness.results.logs.told import FOUND_OUT, Told
from harness.results.metrics import (
    AREA,
    STEPS_TO_GOAL,
    Mixture,
    Moment,
    learning_values,
)
from harness.results.pool import Pool
from harness.results.recordings.runs import meet_same_starts, rescaling_between
from harness.results.trainings import Match, Trainings

OWN: tuple[Pair, Pair] = (BB, KK)
CROSSED: tuple[Pair, Pair] = (BK, KB)
Lost: TypeAlias = tuple[tuple[int, ...], tuple[int, ...]]
NONE_LOST: Lost = ((), ())


def compare_all(
    asked: Sequence[tuple[Trainings, Match]],
    terms: Terms = FIRST,
    manifests: Sequence[Manifest] = (),
    unread: float = 0,
    told: Told = FOUND_OUT,
) -> tuple[Comparison, ...]:
    """All comparisons of an experiment, null controls last.

    Their questions are asked together, and all hints are one family.

    Args:
        asked: The trainings that are compared, each with those of its group.
        terms: What was agreed on before the first training.
        manifests: Of all planned cells: some may be missing, or still to come.
        unread: How many trainings are missing besides.
        told: What the user says of the measures.

    Raises:
        UsageError: It does not fit them.
    """
    swaps = swaps_of(sorted({seed for _, match in asked for of in match.seeds_of for seed in of}))
    seen = Seen.of(manifests, terms.looks or (terms.budget,) * bool(terms.budget))
    found = [
        compare(of, match, swaps, (seen.lost(of.group, match.baseline), seen.lost(of.group, match.proposed)), told)
        for of, match in asked
    ]
    names = dict.fromkeys(change.name for it in found for change in it.measured.changes)
    for name in told.ends:
        if names and name not in names:
            raise UsageError(f"--ends: {unknown_name('measure', name, names)}")
    told_of_all = with_verdicts(found, terms, seen.look_of, seen.to_come + unread)
    return tuple(sorted(told_of_all, key=lambda it: it.is_control))


def compare(
    trainings: Trainings, match: Match, swaps: Swaps, lost: Lost = NONE_LOST, told: Told = FOUND_OUT
) -> Comparison:
    """One reward against another, by all of their trainings; p-values are not corrected yet.

    Args:
        trainings: The trainings of the group.
        match: Those of both rewards.
        swaps: The ways in which the names of a seed's trainings are swapped.
        lost: The seeds of trainings of either that a plan of looks counts, though they left nothing.
        told: What the user says of the measures.
    """
    comparer, read = _Comparer(trainings, match, swaps, lost, told), trainings.read
    measured = Behaviour(
        episodes=comparer.episodes,
        counted=read.counted if read else {},
        deciding=trainings.deciding,
        offered=read.offered if read else (),
        decided_in=trainings.decided_in(comparer.episodes),
        same_starts=not read or meet_same_starts(match.recorded),  # an arm's seeds do
    )
    if all(match.seeds_of):
        everybody = dict.fromkeys(it for side in (*match.sides, match.control) for it in side)
        measured = replace(
            measured,
            changes=comparer.changes(),
            along=comparer.along(),
            mixtures=mixtures_of([it.manifest for it in everybody if it.manifest is not None]),
            same_steps=comparer.same_steps(),
            paid=tuple(comparer.paid_at_random()),
        )
    found = Comparison(trainings.group, match.baseline, match.proposed, match.seeds, match.seeds_of, measured)
    is_rescaled = read and not found.is_control  # an arm's splits say it
    number = Number(
        number_of=trainings.number_of,
        rescaling=rescaling_between(match.recorded, match.proposed, match.baseline) if is_rescaled else None,
        manner=found.manner,
        why_none=found.why_none,
    )
    if not (all(match.seeds_of) and match.seeds):
        return replace(found, number=number)
    decomposition, pairs = comparer.indices()
    returns, missing = comparer.returns()
    number = replace(number, decomposition=decomposition, returns=returns, missing=missing)
    return replace(found, number=number, curves=_CurvesOnDemand(pairs, lambda pair: trainings.curve(match, pair)))


def mixtures_of(manifests: Iterable[Manifest]) -> tuple[Mixture, ...]:
    """The mixtures among done cells. A cell of which a version is not recorded is left out there."""
    started: dict[tuple[str, str], dict[str, list[str]]] = {}
    for manifest in manifests:
        told, made = manifest.environment, manifest.cell.plugins
        recorded = {
            **{(kind, made[kind]): it for kind, it in told.get("sources", {}).items() if kind in made},
            **{("versions", name): it for name, it in told.get("versions", {}).items()},
            ("machine", KERNEL): told.get("machine", {}).get("kernel"),
        }
        for which, version in recorded.items():
            if version:
                started.setdefault(which, {}).setdefault(version, []).append(manifest.started)
    found = list[Mixture]()
    for (kind, name), versions in started.items():
        # Of two versions that made as many, the newer one comes first.
        order = sorted(versions, key=lambda it: (len(versions[it]), max(versions[it])), reverse=True)
        found += [Mixture(kind, name, {it: len(versions[it]) for it in order})] if len(versions) > 1 else []
    return tuple(found)


class _CurvesOnDemand(Mapping[Pair, GroupCurve]):
    """The curves of a comparison. They are read again at each request, because all curves would fill the memory."""

    def __init__(self, pairs: tuple[Pair, ...], read: Callable[[Pair], GroupCurve]) -> None:
        self._pairs, self._read = pairs, read

    def __getitem__(self, pair: Pair) -> GroupCurve:
        if pair not in self._pairs:
            raise KeyError(pair)
        return self._read(pair)

    def __iter__(self) -> Iterator[Pair]:
        return iter(self._pairs)

    def __len__(self) -> int:
        return len(self._pairs)


class _Comparer:
    """Compares the trainings of two rewards."""

    def __init__(self, trainings: Trainings, match: Match, swaps: Swaps, lost: Lost, told: Told) -> None:
        self._trainings, self._match, self._swaps, self._lost, self._told = trainings, match, swaps, lost, told
        self._sides = [[it.measured for it in side] for side in match.sides]
        everything = [it for side in self._sides for it in side]
        self.episodes = {
            manner: min(it.episodes[manner] for it in everything)
            for manner in (everything[0].manners if everything else ())
            if all(manner in it.manners for it in everything)  # a training of version 0.1 may lack one
        }
        """The number of episodes in each manner that all trainings have, as in the one with the fewest."""

    def same_steps(self) -> bool:
        """Whether both rewards taught the same seeds the same steps: each of each evaluation, bit for bit.

        Evaluations are read only if every measure of every seed is the same.
        """
        if not self._match.seeds or self._match.seeds_of != (self._match.seeds, self._match.seeds):
            return False
        is_alike = all(one.manners == other.manners for one, other in zip(*self._sides, strict=True))
        return is_alike and all(one.motion == other.motion != "" for one, other in zip(*self._match.sides, strict=True))

    def indices(self) -> tuple[Decomposition | None, tuple[Pair, ...]]:
        """Both etas with their parts, and the curves that are known; no etas where an own reward is not known."""
        read: dict[Pair, GroupCurve] = {}
        missing = None
        try:
            for pair in (*OWN, *CROSSED):
                read[pair] = self._trainings.curve(self._match, pair)
        except Unscored as unscored:
            missing = str(unscored)
        known = read if missing is None else {pair: read[pair] for pair in OWN if pair in read}
        if not {*OWN} <= known.keys():
            return None, tuple(known)
        signs, control = self._swaps.of(self._match.seeds), self._trainings.control(self._match)
        return decompose(known, missing=missing, signs=signs, control=control), tuple(known)

    def returns(self) -> tuple[dict[str, ReturnSplit], dict[str, str]]:
        """The split of the mean return in each manner; the reason where an own return is not known.

        Of an arm in that of its final evaluation alone.
        """
        found, missing, match = dict[str, ReturnSplit](), dict[str, str](), self._match
        own_manner = OWN_AND_OTHER[self._trainings.group.deterministic][:1]
        for manner in self.episodes if self._trainings.read else own_manner:
            values, reasons = dict[Pair, list[float]](), dict[Pair, str]()
            for pair in (*OWN, *CROSSED):
                try:
                    by = match.of(pair[0])[0]
                    values[pair] = [it.returned(by, manner) for it in match.of(pair[1])]
                except Unscored as unscored:
                    reasons[pair] = str(unscored)
            own, crossed = (next((reasons[it] for it in pairs if it in reasons), None) for pairs in (OWN, CROSSED))
            if own is not None:
                missing[manner] = own
                continue
            known = values if crossed is None else {pair: values[pair] for pair in OWN}
            swaps = self._swaps if self._trainings.number_of == "returns" else None
            found[manner] = split_returns(known, match.seeds, swaps, crossed)
        return found, missing

    def paid_at_random(self) -> Iterator[PaidAtRandom]:
        """What each reward pays its own policies and random actions, as far as it is known."""
        sides = dict(zip((self._match.proposed, self._match.baseline), reversed(self._match.sides), strict=True))
        for reward in dict.fromkeys((self._match.baseline, self._match.proposed)):
            with suppress(Unscored):
                paid = [it.returned(it, with_events=True) for it in sides[reward]]
                if found := paid_at_random(reward, paid, sides[reward][0].random_pay()):
                    yield found

    def changes(self) -> tuple[Change, ...]:
        """The measures of the trained policies in each manner, of the trainings, and of how fast they learned."""
        found = [
            self._change(
                self._trainings.quantity(name, manner, episodes),
                *([it.manners[manner] for it in side] for side in self._sides),
            )
            for manner, episodes in self.episodes.items()
            for name in self._trainings.names
        ]
        return (*found, *self._last(), *self._learned())

    def _learned(self) -> list[Change]:
        """How fast the trainings learned, by the share of episodes that end in success."""
        success, steps = self._trainings.success, self._trainings.group.steps
        if not success or not self._trainings.group.evaluate_every:
            return []
        sides = [[learning_values(its, steps, success) for its in side] for side in self._moments]
        measures = (
            Quantity(AREA, "", "higher", LEARNING, bounds=SHARE),
            Quantity(STEPS_TO_GOAL, "steps", "lower", LEARNING, bounds=(0.0, float(steps))),
        )
        return [self._change(it, *sides) for it in measures]

    def _last(self) -> list[Change]:
        """The measures that decide, means over the last evaluations; none where only the final policy was evaluated."""
        sides = [[self._trainings.last_of(it) for it in side] for side in self._match.sides]
        episodes = next(iter(self.episodes.values()), 0)
        return [
            self._change(self._trainings.quantity(name, LAST, episodes), *sides)
            for name in self._trainings.deciding
            if all(name in values for side in sides for values in side)
        ]

    def along(self) -> tuple[StepChange, ...]:
        """The measures that decide, at each evaluation before the end of the trainings that all have."""
        group, names = self._trainings.group, [it for it in self._trainings.deciding if it in self._trainings.names]
        if not group.evaluate_every:
            return ()
        episodes = next(iter(self.episodes.values()))  # of the cells' own manner
        sides = [[it.on_the_way(group.evaluate_every) for it in side] for side in self._match.sides]

        def change(name: str, due: int) -> Change:
            measure = self._trainings.quantity(name, f"after {due:,} steps", episodes)
            return self._change(measure, *([its[due][1].behaviour for its in side] for side in sides))

        in_all = set.intersection(*(set(its) for side in sides for its in side))
        return tuple(
            StepChange(due, tuple(change(name, due) for name in names)) for due in sorted(in_all) if due < group.steps
        )

    @cached_property
    def _moments(self) -> list[list[Sequence[Moment]]]:
        """The evaluations of each training by the baseline, then of each by the proposed reward."""
        return [[it.moments for it in side] for side in self._match.sides]

    def _change(self, measure: Quantity, *sides: Iterable[Mapping[str, float | None]]) -> Change:
        name, manner = measure.name, measure.manner
        values = ([it.get(name) for it in side] for side in sides)
        one, other = (
            {**dict(zip(seeds, of, strict=True)), **dict.fromkeys(lost)}
            for seeds, of, lost in zip(self._match.seeds_of, values, self._lost, strict=True)
        )
        known = [it for side in (one, other) for it in side.values() if it is not None]
        measure = measure._replace(bounds=ends_of(name, measure.ends, self._told.ends, known))
        # Nobody measured how random actions learn.
        has_floor = manner in (DETERMINISTIC, STOCHASTIC, TRAINING) or manner.startswith(EVALUATION)
        random = [it.random.get(name) for side in self._sides for it in side] if has_floor else []
        reasons = (why for side in self._match.sides for it in side if (why := it.reason(name, manner)))
        return replace(change_of(measure, one, other, self._swaps, random), reason=next(reasons, ""))


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


def correct(family: Sequence[Comparison]) -> tuple[Comparison, ...]:
    """Comparisons with p-values that hold for all of their claims together."""
    p_values = corrected_where_known([outcomes for comparison in family for outcomes in comparison.outcomes])
    left, count = iter(p_values), sum(p is not None for p in p_values)
    return tuple(comparison.with_corrected(left, count) for comparison in family)
