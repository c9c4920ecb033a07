"""Two rewards that trained in one group of cells, compared: the same for traces of an arm and for recordings."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Generic, Literal, Protocol, Self, TypeVar

from harness.arrays import Float
from harness.errors import Unscored
from harness.eta.behaviour_change import Change, Quantity, change_of
from harness.eta.curve import GroupCurve
from harness.eta.decompose import decompose
from harness.eta.paid_at_random import PaidAtRandom, paid_at_random
from harness.eta.return_split import ReturnSplit, split_returns
from harness.eta.scored_sums import BB, BK, KB, KK, Pair
from harness.eta.splits import Decomposition
from harness.eta.swaps import Swaps
from harness.results.along import Moments, changes_along, learning_changes
from harness.results.comparison import Comparison, Group, StepChange
from harness.results.measured import LAST, Measured, Moment, last_values
from harness.results.mixture import Mixture

OWN: tuple[Pair, Pair] = (BB, KK)
CROSSED: tuple[Pair, Pair] = (BK, KB)
Training = TypeVar("Training")


@dataclass(frozen=True)
class Match(Generic[Training]):
    """The trainings of one comparison, in the order of the seeds.

    Attributes:
        baseline: The label of the reward that the other one is compared with.
        proposed: The label of the other one.
        seeds: The seeds that both have; of the null control those of the baseline. What is paid is compared on them.
        of_baseline: The trainings by the baseline, of these seeds.
        of_proposed: The trainings by the other reward, of these seeds.
        control: The baseline's trainings again with other seeds, if there are some for all seeds.
        others: The trainings of each reward whose seed the other one lacks, by seed. Behaviour is compared on them too.
    """

    baseline: str
    proposed: str
    seeds: tuple[int, ...]
    of_baseline: Sequence[Training]
    of_proposed: Sequence[Training]
    control: Sequence[Training] = ()
    others: tuple[Mapping[int, Training], Mapping[int, Training]] = field(default=({}, {}))

    @classmethod
    def of_seeds(
        cls,
        names: tuple[str, str],
        baseline: Mapping[int, Training],
        proposed: Mapping[int, Training],
        control: Mapping[int, Training],
    ) -> Self:
        """Sort trainings by what both rewards have.

        Args:
            names: The labels of both rewards. Equal ones are the null control.
            baseline: The baseline's trainings, by seed.
            proposed: The other reward's.
            control: The baseline's trainings with other seeds, by the seed that they stand beside.
        """
        seeds = tuple(sorted(baseline.keys() & proposed.keys()))
        again = [control[seed] for seed in seeds if seed in control]
        alone = {seed: baseline[seed] for seed in sorted(baseline.keys() - proposed.keys())}
        others = {seed: proposed[seed] for seed in sorted(proposed.keys() - baseline.keys())}
        return cls(
            *names,
            seeds,
            [baseline[seed] for seed in seeds],
            [proposed[seed] for seed in seeds],
            again if len(again) == len(seeds) else [],
            ({}, {}) if names[0] == names[1] else (alone, others),
        )

    @property
    def sides(self) -> tuple[Sequence[Training], Sequence[Training]]:
        """All trainings of both rewards, those of the seeds that both have first."""
        alone, others = self.others
        return [*self.of_baseline, *alone.values()], [*self.of_proposed, *others.values()]

    @property
    def seeds_of(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """The seeds of `sides`."""
        alone, others = self.others
        return (*self.seeds, *alone), (*self.seeds, *others)

    @property
    def is_paired(self) -> bool:
        """Whether both rewards trained with the same seeds."""
        return not any(self.others)

    def of(self, who: str) -> Sequence[Training]:
        """The trainings of one side with the seeds that both have, ``baseline`` or ``proposed``."""
        return self.of_baseline if who == "baseline" else self.of_proposed


class Trainings(Protocol[Training]):
    """The trainings of one group, as far as a comparison asks about them: cells of an arm, or recordings."""

    @property
    def group(self) -> Group:
        """What all of them share."""

    @property
    def names(self) -> Sequence[str]:
        """The names of the measures."""

    @property
    def deciding(self) -> tuple[str, ...]:
        """The names of the measures that decide, in this order."""

    @property
    def success(self) -> str:
        """The name of the share of episodes by which learning is measured; empty if there is none."""

    @property
    def averaged(self) -> int:
        """The final policy counts with the mean over so many of the last evaluations, at most."""

    @property
    def number_of(self) -> Literal["returns", "indices"]:
        """What the sentence about the number tells. Only what it tells makes a claim, besides the indices."""

    def decided_in(self, episodes: Mapping[str, int]) -> str:
        """The manner that decides; empty for that of the cells."""

    def measured(self, training: Training) -> Measured:
        """Every measure of a training, by manner."""

    def moments(self, training: Training) -> Sequence[Moment]:
        """Its evaluations, the one after the training last."""

    def measure(self, name: str, manner: str, episodes: int) -> Quantity:
        """What a measure is in the episodes of one manner, of which each seed has so many at least."""

    def has_floor(self, manner: str) -> bool:
        """Whether random actions are shown beside the episodes of a manner."""

    def reason(self, match: Match[Training], name: str, manner: str) -> str:
        """Why a measure has no value in some training; empty if it has one in all."""

    def curve(self, match: Match[Training], pair: Pair) -> GroupCurve:
        """S_r(tau_q) of one pair (r, q).

        Raises:
            Unscored: It is not known what r pays these trainings.
        """

    def control(self, match: Match[Training]) -> GroupCurve | None:
        """The curve of the baseline's trainings with other seeds."""

    def return_manners(self, episodes: Mapping[str, int]) -> Sequence[str]:
        """The manners in which mean returns are compared."""

    def returned(self, match: Match[Training], pair: Pair, manner: str) -> list[float]:
        """R_r(q) of every seed, of one pair (r, q).

        Raises:
            Unscored: It is not known.
        """

    def paid_beside_random(self, trainings: Sequence[Training]) -> tuple[list[float], Float]:
        """What one reward paid in the evaluation of each of its trainings, and what it pays random actions.

        Args:
            trainings: At least one; all by one reward.

        Returns:
            The mean return of an episode, of each training; the returns of random actions, (episodes,).

        Raises:
            Unscored: It is not known.
        """

    def same_steps(self, match: Match[Training]) -> bool:
        """Whether both rewards taught the same steps: every step of each evaluation of every seed, bit for bit."""

    def mixtures(self, match: Match[Training]) -> tuple[Mixture, ...]:
        """Plugins of which several versions were used."""


def compare(trainings: Trainings[Training], match: Match[Training], swaps: Swaps) -> Comparison:
    """One reward against another, by all of their trainings; p-values are not corrected yet.

    Args:
        trainings: The trainings of the group.
        match: Those of both rewards.
        swaps: The ways in which the names of a seed's trainings are swapped.
    """
    comparer = _Comparer(trainings, match, swaps)
    empty = Comparison(
        trainings.group,
        match.baseline,
        match.proposed,
        match.seeds,
        None,
        (),
        {},
        episodes=comparer.episodes,
        deciding=trainings.deciding,
        decided_in=trainings.decided_in(comparer.episodes),
        number_of=trainings.number_of,
        trained=match.seeds_of,
    )
    if not all(match.seeds_of):
        return empty
    behaviour = replace(
        empty,
        changes=comparer.changes(),
        along=comparer.along(),
        mixtures=trainings.mixtures(match),
        paid=tuple(comparer.paid_at_random()),
    )
    if not match.seeds:
        return behaviour
    decomposition, pairs = comparer.indices()
    returns, missing = comparer.returns()
    return replace(
        behaviour,
        decomposition=decomposition,
        curves=_CurvesOnDemand(pairs, lambda pair: trainings.curve(match, pair)),
        same_steps=match.is_paired and trainings.same_steps(match),
        returns=returns,
        missing=missing,
    )


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


class _Comparer(Generic[Training]):
    """Compares the trainings of two rewards."""

    def __init__(self, trainings: Trainings[Training], match: Match[Training], swaps: Swaps) -> None:
        self._trainings, self._match, self._swaps = trainings, match, swaps
        self._one, self._other = ([trainings.measured(it) for it in side] for side in match.sides)
        self.episodes = _fewest_episodes([*self._one, *self._other])
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
        """The split of the mean return in each manner; the reason where an own return is not known."""
        found, missing = dict[str, ReturnSplit](), dict[str, str]()
        for manner in self._trainings.return_manners(self.episodes):
            values, reasons = self._returned(manner)
            own, crossed = (next((reasons[it] for it in pairs if it in reasons), None) for pairs in (OWN, CROSSED))
            if own is not None:
                missing[manner] = own
                continue
            known = values if crossed is None else {pair: values[pair] for pair in OWN}
            swaps = self._swaps if self._trainings.number_of == "returns" else None
            found[manner] = split_returns(known, self._match.seeds, swaps, crossed)
        return found, missing

    def _returned(self, manner: str) -> tuple[dict[Pair, list[float]], dict[Pair, str]]:
        values, reasons = dict[Pair, list[float]](), dict[Pair, str]()
        for pair in (*OWN, *CROSSED):
            try:
                values[pair] = self._trainings.returned(self._match, pair, manner)
            except Unscored as unscored:
                reasons[pair] = str(unscored)
        return values, reasons

    def paid_at_random(self) -> Iterator[PaidAtRandom]:
        """What each reward pays its own policies and random actions, as far as it is known."""
        sides = dict(zip((self._match.proposed, self._match.baseline), reversed(self._match.sides), strict=True))
        for reward in dict.fromkeys((self._match.baseline, self._match.proposed)):
            with suppress(Unscored):
                found = paid_at_random(reward, *self._trainings.paid_beside_random(sides[reward]))
                if found is not None:
                    yield found

    def changes(self) -> tuple[Change, ...]:
        """The measures of the trained policies in each manner, of the trainings, and of how fast they learned."""
        found = [
            self._change(
                self._trainings.measure(name, manner, episodes),
                *([it.manners[manner].get(name) for it in side] for side in (self._one, self._other)),
            )
            for manner, episodes in self.episodes.items()
            for name in self._trainings.names
        ]
        success = self._trainings.success if self._is_evaluated else ""
        learned = learning_changes(self._trainings.group, self._moments, success, self._change) if success else []
        return (*found, *self._last(), *learned)

    def _last(self) -> list[Change]:
        """The measures that decide, means over the last evaluations; none where only the final policy was evaluated."""
        most, budget = self._trainings.averaged, self._trainings.group.steps
        if most < 2 or not self._is_evaluated:
            return []
        one, other = ([last_values(its, budget, most) for its in side] for side in self._moments)
        names = [name for name in self._trainings.deciding if all(name in values for values in (*one, *other))]
        episodes = next(iter(self.episodes.values()), 0)
        return [
            self._change(
                self._trainings.measure(name, LAST, episodes), *([it[name] for it in side] for side in (one, other))
            )
            for name in names
        ]

    def along(self) -> tuple[StepChange, ...]:
        """The measures that decide, at each evaluation before the end of the trainings."""
        if not self._is_evaluated:
            return ()
        names = [name for name in self._trainings.deciding if name in self._trainings.names]
        episodes = next(iter(self.episodes.values()))  # of the cells' own manner

        def change(name: str, manner: str, *sides: Sequence[float | None]) -> Change:
            return self._change(self._trainings.measure(name, manner, episodes), *sides)

        return changes_along(self._trainings.group, self._moments, names, change)

    @property
    def _is_evaluated(self) -> bool:
        return bool(self._trainings.group.evaluate_every)

    @cached_property
    def _moments(self) -> Moments:
        one, other = ([self._trainings.moments(it) for it in side] for side in self._match.sides)
        return one, other

    def _change(self, measure: Quantity, *sides: Sequence[float | None]) -> Change:
        one, other = (dict(zip(*pair, strict=True)) for pair in zip(self._match.seeds_of, sides, strict=True))
        has_floor = self._trainings.has_floor(measure.manner)
        random = [it.random.get(measure.name) for it in (*self._one, *self._other)] if has_floor else []
        reason = self._trainings.reason(self._match, measure.name, measure.manner)
        return replace(change_of(measure, one, other, self._swaps, random), reason=reason)


def _fewest_episodes(measured: Sequence[Measured]) -> dict[str, int]:
    """The fewest episodes by manner. A manner that some training lacks, such as one of version 0.1, is left out."""
    manners = measured[0].manners if measured else ()
    return {
        manner: min(it.episodes[manner] for it in measured)
        for manner in manners
        if all(manner in it.manners for it in measured)
    }
