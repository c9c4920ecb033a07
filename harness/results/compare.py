"""Two rewards that trained in one group of cells, compared: the same for traces of an arm and for recordings."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from typing import TypeAlias

from harness.errors import Unscored, UsageError
from harness.eta.behaviour_change import Change, Quantity, change_of
from harness.eta.curve import GroupCurve
from harness.eta.decomposition import decompose
from harness.eta.headline import PaidAtRandom, ReturnSplit, paid_at_random, split_returns
from harness.eta.interval import SHARE
from harness.eta.laws import ends_of
from harness.eta.manner import DETERMINISTIC, EVALUATION, LAST, LEARNING, OWN_AND_OTHER, STOCHASTIC, TRAINING
from harness.eta.splits import BB, BK, KB, KK, Decomposition, Pair
from harness.eta.swaps import Swaps, swaps_of
from harness.record.cell import Manifest
from harness.record.terms import FIRST, Terms
from harness.registry.spec import unknown_name
from harness.results.comparison import Behaviour, Comparison, Number, StepChange
from harness.results.logs.told import FOUND_OUT, Told
from harness.results.metrics import (
    AREA,
    STEPS_TO_GOAL,
    Moment,
    learning_values,
    mixtures_of,
)
from harness.results.recordings.runs import meet_same_starts, rescaling_between
from harness.results.trainings import Match, Trainings
from harness.results.verdicts import Seen, with_verdicts

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
    """All comparisons of an experiment. Their questions are asked together, and all hints are one family.

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
    return with_verdicts(found, terms, seen.look_of, seen.to_come + unread)


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
            same_steps=match.same_steps,
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
