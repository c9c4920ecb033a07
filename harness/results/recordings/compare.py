"""Two rewards that trained in one env: returns, how they split, and what the policies did."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from harness.eta.behaviour_change import Change, Measure, change_of
from harness.eta.curve import GroupCurve, Kind, stream_curve
from harness.eta.decompose import decompose
from harness.eta.return_split import Returns, ReturnSplit, split_returns
from harness.eta.scored_sums import BB, BK, KB, KK, Pair
from harness.eta.splits import Decomposition
from harness.eta.swaps import Swaps
from harness.record.recording.facts import REWARD
from harness.results.along import Moments, changes_along, learning_changes
from harness.results.comparison import Comparison, StepChange
from harness.results.measured import EVALUATION
from harness.results.recordings.episodes import Part
from harness.results.recordings.runs import MANNERS, Run, Runs

PAIRS = (BB, KK, BK, KB)


def compare(runs: Runs, baseline: str, proposed: str, swaps: Swaps, kind: Kind = "accumulated") -> Comparison:
    """One reward against another, by the seeds that were trained with both; p-values are not corrected yet."""
    others = {seed: run for (name, seed), run in runs.members.items() if name == proposed}
    others = dict(runs.control) if baseline == proposed else others
    seeds = tuple(seed for name, seed in sorted(runs.members) if name == baseline and seed in others)
    sides = {
        "baseline": [runs.members[baseline, seed] for seed in seeds],
        "proposed": [others[seed] for seed in seeds],
    }
    return _Comparer(runs, {"baseline": baseline, "proposed": proposed}, seeds, sides, swaps, kind).compare()


class _Comparer:
    """Compares the trainings of two rewards."""

    def __init__(
        self,
        runs: Runs,
        rewards: Mapping[str, str],
        seeds: tuple[int, ...],
        sides: Mapping[str, Sequence[Run]],
        swaps: Swaps,
        kind: Kind,
    ) -> None:
        self._runs, self._rewards, self._seeds, self._swaps, self._kind = runs, rewards, seeds, swaps, kind
        self._sides = sides
        parts = {who: [run.parts(runs.steps) for run in members] for who, members in sides.items()}
        everyone = [it for members in parts.values() for it in members]
        self._manners = [manner for manner in MANNERS if seeds and all(manner in it for it in everyone)]
        self._parts: dict[str, dict[str, list[Part]]] = {
            manner: {who: [it[manner] for it in members] for who, members in parts.items()} for manner in self._manners
        }

    def compare(self) -> Comparison:
        """All of it."""
        returns: dict[str, ReturnSplit] = {}
        missing: dict[str, str] = {}
        for manner in self._manners:
            found = self._returns(manner)
            if isinstance(found, str):
                missing[manner] = found
            else:
                returns[manner] = found
        curves = self._curves()
        return Comparison(
            self._runs.group,
            self._rewards["baseline"],
            self._rewards["proposed"],
            self._seeds,
            self._indices(curves),
            (*self._changes(), *self._learning()),
            curves,
            self._along(),
            episodes={manner: self._fewest(manner) for manner in self._manners},
            returns=returns,
            missing=missing,
            deciding=self._runs.measures[:1],
            decided_in=next((it for it in self._manners if self._fewest(it)), MANNERS[-1]),
        )

    def _fewest(self, manner: str) -> int:
        return min(part.episodes for members in self._parts[manner].values() for part in members)

    def _returns(self, manner: str) -> ReturnSplit | str:
        """The split; the reason where not even the trainings' own returns are known."""
        values: dict[Pair, list[float]] = {}
        reasons: dict[Pair, str] = {}
        for pair in PAIRS:
            found = self._paid(manner, pair)
            if isinstance(found, str):
                reasons[pair] = found
            else:
                values[pair] = found
        own = next((reasons[pair] for pair in (BB, KK) if pair in reasons), None)
        if own is not None:
            return own
        crossed = next((reasons[pair] for pair in (BK, KB) if pair in reasons), None)
        known: Returns = values if crossed is None else {pair: values[pair] for pair in (BB, KK)}
        return split_returns(known, self._seeds, self._swaps, crossed)

    def _paid(self, manner: str, pair: Pair) -> list[float] | str:
        """R_r(q) of every seed; the reason where one is not known."""
        payer, values = self._rewards[pair[0]], []
        for run, part in zip(self._sides[pair[1]], self._parts[manner][pair[1]], strict=True):
            value = part.returns.get(payer)
            if value is None:
                return _why(payer, run, part)
            values.append(value)
        return values

    def _changes(self) -> Iterator[Change]:
        """Every measure in every manner."""
        for manner in self._manners:
            for name in self._runs.measures:
                one, other = ([part.behaviour.get(name) for part in self._parts[manner][who]] for who in self._sides)
                yield self._explained(self._change(self._measure(name, manner), one, other), manner)

    def _along(self) -> tuple[StepChange, ...]:
        """The measure that decides, at each evaluation before the end of the trainings."""
        if not self._is_evaluated:
            return ()

        def change(name: str, manner: str, *sides: Sequence[float | None]) -> Change:
            measure = self._measure(name, EVALUATION)._replace(manner=manner)
            return self._change(measure, *sides)

        return changes_along(self._runs.group, self._moments, self._runs.measures[:1], change)

    def _learning(self) -> list[Change]:
        """How fast the trainings learned, if the measure that decides is a share of episodes."""
        success = next(iter(self._runs.measures), "")
        if not (self._is_evaluated and success and self._runs.is_flag(success)):
            return []
        return learning_changes(self._runs.group, self._moments, success, self._change)

    @property
    def _is_evaluated(self) -> bool:
        return bool(self._runs.group.evaluate_every and self._seeds)

    @property
    def _moments(self) -> Moments:
        one, other = ([run.moments(self._runs.steps) for run in self._sides[who]] for who in self._sides)
        return one, other

    def _measure(self, name: str, manner: str) -> Measure:
        return self._runs.measure(name, manner, self._fewest(manner))

    def _change(self, measure: Measure, one: Sequence[float | None], other: Sequence[float | None]) -> Change:
        baseline, proposed = (dict(zip(self._seeds, values, strict=True)) for values in (one, other))
        is_of_policies = measure.manner.startswith(EVALUATION)
        random = self._runs.random.whole.behaviour.get(measure.name) if self._runs.random and is_of_policies else None
        return change_of(measure, baseline, proposed, self._swaps, () if random is None else (random,))

    def _explained(self, change: Change, manner: str) -> Change:
        """The same, with the reason of the first training that lacks the measure."""
        name = change.name
        reasons = (
            _why(name, run, part)
            for who, members in self._sides.items()
            for run, part in zip(members, self._parts[manner][who], strict=True)
            if part.behaviour.get(name) is None
        )
        return replace(change, reason=next(reasons, ""))

    def _curves(self) -> Mapping[Pair, GroupCurve]:
        if not self._seeds:
            return {}
        pairs = [pair for pair in PAIRS if self._is_paid_everywhere(pair)]
        return _CurvesOnDemand(self, tuple(pairs))

    def _is_paid_everywhere(self, pair: Pair) -> bool:
        payer = self._rewards[pair[0]]
        return all(
            payer in run.facts.rewards and f"{REWARD}{payer}" not in run.episodes.reasons
            for run in self._sides[pair[1]]
        )

    def curve(self, pair: Pair) -> GroupCurve:
        """S_r(tau_q), read from the files."""
        return self._curve(self._rewards[pair[0]], self._sides[pair[1]])

    def _indices(self, curves: Mapping[Pair, GroupCurve]) -> Decomposition | None:
        if not {BB, KK} <= curves.keys():
            return None
        whole = set(PAIRS) <= curves.keys()
        read = {pair: curves[pair] for pair in (PAIRS if whole else (BB, KK))}
        missing = None if whole else "a reward is not known in all trainings"
        return decompose(read, missing=missing, signs=self._swaps.of(self._seeds), control=self._control())

    def _control(self) -> GroupCurve | None:
        """The baseline's curve with other seeds: how far two trainings by one reward are apart."""
        again = [self._runs.control[seed] for seed in self._seeds if seed in self._runs.control]
        if len(again) < len(self._seeds) or self._rewards["baseline"] != self._runs.trained[0]:
            return None
        return self._curve(self._rewards["baseline"], again)

    def _curve(self, payer: str, members: Sequence[Run]) -> GroupCurve:
        return stream_curve((run.paid_by(payer) for run in members), len(members), self._runs.steps, self._kind)


class _CurvesOnDemand(Mapping[Pair, GroupCurve]):
    """Those of all comparisons would fill the memory."""

    def __init__(self, comparer: _Comparer, pairs: tuple[Pair, ...]) -> None:
        self._comparer, self._pairs = comparer, pairs

    def __getitem__(self, pair: Pair) -> GroupCurve:
        if pair not in self._pairs:
            raise KeyError(pair)
        return self._comparer.curve(pair)

    def __iter__(self) -> Iterator[Pair]:
        return iter(self._pairs)

    def __len__(self) -> int:
        return len(self._pairs)


def _why(name: str, run: Run, part: Part) -> str:
    """Why a reward or a measure has no value in a training."""
    return f"{name} in '{run.path}': {part.reasons.get(name, 'not recorded')}"
