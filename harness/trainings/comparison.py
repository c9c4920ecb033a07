"""Two rewards that trained in one env: returns, how they split, and what the policies did."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from harness.arrays import Float
from harness.eta.behaviour_change import Change, Measure, change_of
from harness.eta.curve import GroupCurve, Kind, stream_curve
from harness.eta.decompose import decompose
from harness.eta.headline import Headline, Names, judge, number_sentence, return_sentence
from harness.eta.index import Index
from harness.eta.return_split import Returns, ReturnSplit, split_returns
from harness.eta.scored_sums import BB, BK, KB, KK, Pair
from harness.eta.splits import Decomposition, Splits
from harness.eta.swaps import Swaps, smallest_p
from harness.record.recording.facts import REWARD
from harness.trainings.episodes import Part
from harness.trainings.runs import EVALUATION, MANNERS, Run, Runs

PAIRS = (BB, KK, BK, KB)
UNMEASURED = (
    "No behaviour was recorded, and rewards alone cannot tell whether the agent behaves better: give RecordRewards a "
    "measure of it, such as success."
)


@dataclass(frozen=True, eq=False)
class Comparison:
    """One reward against another.

    Attributes:
        baseline: The one that comes first.
        proposed: The other one.
        seeds: Those that were trained with both, and are compared.
        returns: By manner, the split of the mean return of an episode; only where both own returns are known.
        missing: By manner, why there is none.
        indices: I_N and I_P of the summed rewards; None without a seed, and where an own reward is not known.
        changes: Measures of behaviour in every manner.
        curves: S_r(tau_q) by (r, q), read anew each time that one is asked for.
        episodes: By manner, so many of each seed at least.
        manner: Where the verdict looks.
        deciding: The measure that decides; None where no behaviour was recorded.
        claims: How many are made together.
    """

    baseline: str
    proposed: str
    seeds: tuple[int, ...]
    returns: Mapping[str, ReturnSplit]
    missing: Mapping[str, str]
    indices: Decomposition | None
    changes: tuple[Change, ...]
    curves: Mapping[Pair, GroupCurve]
    episodes: Mapping[str, int]
    manner: str
    deciding: str | None
    claims: int = 0

    @property
    def names(self) -> Names:
        """Of both rewards."""
        return Names(self.baseline, self.proposed)

    @property
    def main(self) -> ReturnSplit | None:
        """The returns where the verdict looks."""
        return self.returns.get(self.manner)

    @property
    def splits(self) -> Splits:
        """eta_N and eta_P; one whose index is 0 under both rewards is left out."""
        if self.indices is None:
            return {}
        sums = {
            "eta_N": (self.indices.baseline.negative_sum, self.indices.proposed.negative_sum),
            "eta_P": (self.indices.baseline.positive_sum, self.indices.proposed.positive_sum),
        }
        return {name: split for name, split in self.indices.splits.items() if any(sums[name])}

    @property
    def baseline_index(self) -> Index | None:
        """None where the summed reward is not known."""
        return None if self.indices is None else self.indices.baseline

    @property
    def proposed_index(self) -> Index | None:
        """The same of the proposed reward."""
        return None if self.indices is None else self.indices.proposed

    def changes_in(self, manner: str) -> tuple[Change, ...]:
        """The measures of one manner."""
        return tuple(change for change in self.changes if change.measure.manner == manner)

    @property
    def decisive(self) -> Change | None:
        """The measure that decides, where the verdict looks."""
        return next((change for change in self.changes_in(self.manner) if change.name == self.deciding), None)

    @cached_property
    def headline(self) -> Headline:
        """What it comes to: the agent, and the number."""
        if not self.seeds:
            told = f"Nothing to compare: no seed was trained with both {self.baseline} and {self.proposed}."
            return judge(self.names, [], "", unmeasured=told)
        deciding = [self.decisive] if self.decisive is not None and self.decisive.seeds else []
        told = UNMEASURED
        if self.decisive is not None:
            told = f"{self.deciding} is not known: {self.decisive.reason or 'no episode ended'}."
        return judge(self.names, deciding, self.number, self.claims, told)

    @property
    def number(self) -> str:
        """How much the mean return changed, and how much of that is ruler, in words."""
        if self.main is None:
            return f"The mean return is not known: {self.missing.get(self.manner, 'there is no seed')}."
        return return_sentence(self.names, self.main)

    @property
    def index_number(self) -> str:
        """The same of I_N and I_P; empty where there are none."""
        return number_sentence(self.names, self.splits)

    @property
    def basis(self) -> str:
        """Which episodes the verdict rests on."""
        if not self.seeds:
            return ""
        count = self.episodes[self.manner]
        told = f"{count:,} episode{'s' * (count != 1)} or more of each seed"
        if self.manner == EVALUATION:
            return f"The verdict rests on evaluations of the final policies, {told}."
        return (
            f"The verdict rests on the training itself, {told} {self.manner}: evaluations of the final policies were "
            "not recorded for all seeds. harness.evaluate_policy records one."
        )

    @property
    def outcomes(self) -> list[Float | None]:
        """What every claim would have come to with the names swapped: returns, both etas, all changes."""
        splits = [it.ratio.outcomes for it in self.returns.values()]
        indices = [] if self.indices is None else [self.indices.negative.outcomes, self.indices.positive.outcomes]
        return [*splits, *indices, *(change.outcomes for change in self.changes)]

    def with_corrected(self, p_values: Iterator[float | None], claims: int) -> "Comparison":
        """The same with p-values that hold for all claims together, in the order of `outcomes`."""
        returns = {manner: it.with_corrected(next(p_values)) for manner, it in self.returns.items()}
        indices = self.indices
        if indices is not None:
            indices = indices.with_corrected(next(p_values), next(p_values))
        changes = tuple(replace(change, corrected=next(p_values)) for change in self.changes)
        return replace(self, returns=returns, indices=indices, changes=changes, claims=claims)

    def to_json(self) -> dict[str, Any]:
        """Plain data, the curves left out."""
        headline = {"agent" if name == "robot" else name: told for name, told in self.headline.to_json().items()}
        return {
            "baseline": self.baseline,
            "proposed": self.proposed,
            "seeds": list(self.seeds),
            "headline": headline,
            "rests_on": self.basis,
            "decided_in": self.manner,
            "deciding_measure": self.deciding,
            "returns": {manner: it.to_json() for manner, it in self.returns.items()},
            "returns_missing": dict(self.missing),
            "indices": self.indices and self.indices.to_json(),
            "behaviour": [change.to_json() for change in self.changes],
            "episodes": dict(self.episodes),
            "claims": self.claims,
            "smallest_p": smallest_p(len(self.seeds)) if self.seeds else None,
        }


def compare(runs: Runs, baseline: str, proposed: str, swaps: Swaps, kind: Kind = "accumulated") -> Comparison:
    """One reward against another, by the seeds that were trained with both; p-values are not corrected yet."""
    seeds = tuple(seed for name, seed in sorted(runs.members) if name == baseline and (proposed, seed) in runs.members)
    sides = {
        "baseline": [runs.members[baseline, seed] for seed in seeds],
        "proposed": [runs.members[proposed, seed] for seed in seeds],
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
        baseline, proposed = self._rewards["baseline"], self._rewards["proposed"]
        return Comparison(
            baseline,
            proposed,
            self._seeds,
            returns,
            missing,
            self._indices(curves),
            tuple(self._change(name, manner) for manner in self._manners for name in self._runs.measures),
            curves,
            {manner: self._fewest(manner) for manner in self._manners},
            next((it for it in self._manners if self._fewest(it)), MANNERS[-1]),
            next(iter(self._runs.measures), None),
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

    def _change(self, name: str, manner: str) -> Change:
        baseline, proposed = (
            {seed: part.behaviour.get(name) for seed, part in zip(self._seeds, self._parts[manner][who], strict=True)}
            for who in ("baseline", "proposed")
        )
        episodes = self._fewest(manner) if self._runs.is_flag(name) else None
        measure = Measure(name, "", self._runs.better(name), manner, episodes, bounds=self._runs.bounds(name))
        change = change_of(measure, baseline, proposed, self._swaps)
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
        payer, members = self._rewards[pair[0]], self._sides[pair[1]]
        return stream_curve((run.paid_by(payer) for run in members), len(members), self._runs.steps, self._kind)

    def _indices(self, curves: Mapping[Pair, GroupCurve]) -> Decomposition | None:
        if not {BB, KK} <= curves.keys():
            return None
        whole = set(PAIRS) <= curves.keys()
        read = {pair: curves[pair] for pair in (PAIRS if whole else (BB, KK))}
        missing = None if whole else "a reward is not known in all trainings"
        return decompose(read, missing=missing, signs=self._swaps.of(self._seeds))


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
