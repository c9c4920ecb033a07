"""From an experiment's records to its comparisons."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import combinations
from typing import NamedTuple

from harness.errors import Unscored
from harness.eta.behaviour_change import Change, Measure, change_of
from harness.eta.curve import GroupCurve
from harness.eta.decompose import decompose
from harness.eta.headline import DECIDING, SUCCESS
from harness.eta.return_split import ReturnSplit, split_returns
from harness.eta.scored_sums import BB, BK, KB, KK, Pair
from harness.eta.swaps import Swaps, swaps_of
from harness.record.cell import Cell
from harness.record.folder import EVALUATION
from harness.registry.choice import Choice
from harness.results.along import Moments, changes_along, learning_changes
from harness.results.comparison import Comparison, Group, StepChange, correct_all
from harness.results.measured import DETERMINISTIC, STOCHASTIC, Measured
from harness.results.metrics import measure_of
from harness.results.mixture import mixtures_of
from harness.results.records import Records


def combine(records: Records) -> tuple[Comparison, ...]:
    """Every proposed reward against the baseline, or every two rewards, as the records ask.

    A baseline that is its own proposed reward is the null control.
    """
    asked = sorted(_asked(records), key=lambda it: it[1] == it[2].label)  # the null control comes last
    matches = [_match(records, *it) for it in asked]
    swaps = swaps_of(sorted({seed for match in matches for seed in match.seeds}))
    return correct_all([_compare(records, match, swaps) for match in matches])


def _asked(records: Records) -> list[tuple[Group, str, Choice]]:
    """The group, the baseline and the proposed reward of each comparison."""
    planned = dict.fromkeys(
        (Group.of(manifest.cell), manifest.cell.reward)
        for manifest in records.manifests
        if manifest.status != "skipped"
    )
    against = [
        (group, records.baseline, reward)
        for group, reward in planned
        if reward.label != records.baseline or records.plan.a_a
    ]
    if not records.pairs:
        return against
    others: dict[Group, list[Choice]] = {}
    for group, reward in planned:
        if reward.label != records.baseline:
            others.setdefault(group, []).append(reward)
    return [
        *against,
        *((group, one.label, other) for group, of in others.items() for one, other in combinations(of, 2)),
    ]


class _Match(NamedTuple):
    """The cells of one comparison, in the order of the seeds."""

    group: Group
    baseline: str
    """The label of the reward that the other one is compared with."""
    proposed: Choice
    seeds: tuple[int, ...]
    """The seeds of the baseline's cells, and of the others too unless this is the null control."""
    of_baseline: list[Cell]
    of_proposed: list[Cell]
    control: list[Cell]
    """The cells of the baseline that was trained again with other seeds, if they are done for all."""

    @property
    def cells(self) -> list[Cell]:
        """All cells, each once."""
        return list(dict.fromkeys([*self.of_baseline, *self.of_proposed, *self.control]))


def _match(records: Records, group: Group, label: str, proposed: Choice) -> _Match:
    members = records.groups.get(group, [])
    baseline = {cell.seed: cell for cell in members if cell.reward.label == label}
    of_control = records.plan.control if label == records.baseline else {}
    control = {seed: baseline[other] for seed, other in of_control.items() if other in baseline}
    other = control if proposed.label == label else {it.seed: it for it in members if it.reward == proposed}
    seeds = tuple(sorted(baseline.keys() & other.keys()))
    again = [control[seed] for seed in seeds if seed in control]
    return _Match(
        group,
        label,
        proposed,
        seeds,
        [baseline[seed] for seed in seeds],
        [other[seed] for seed in seeds],
        again if len(again) == len(seeds) else [],
    )


def _compare(records: Records, match: _Match, swaps: Swaps) -> Comparison:
    if not match.seeds:
        return Comparison(match.group, match.baseline, match.proposed.label, (), None, (), {})
    curves, missing = _score(records, match)
    control = records.curve(match.control) if match.control else None
    decomposition = decompose(curves, missing=missing, signs=swaps.of(match.seeds), control=control)
    comparison = _Measures(records, match, swaps)
    returns, missing_returns = _returns(records, match)
    return Comparison(
        match.group,
        match.baseline,
        match.proposed.label,
        match.seeds,
        decomposition,
        comparison.changes(),
        _CurvesOnDemand(records, match, tuple(curves)),
        along=comparison.along(),
        episodes=comparison.episodes,
        mixtures=mixtures_of(map(records.manifest, match.cells)),
        returns=returns,
        missing=missing_returns,
        number_of="indices",
    )


def _returns(records: Records, match: _Match) -> tuple[dict[str, ReturnSplit], dict[str, str]]:
    """The mean return of an episode of the final evaluation, its events left out, and what it splits into.

    It makes no claim: those about the number are made of both indices, as in the note.
    """
    manner = DETERMINISTIC if match.group.deterministic else STOCHASTIC
    values, missing = dict[Pair, list[float]](), None
    for pair in (BB, KK, BK, KB):
        own, cells = (match.of_baseline if who == "baseline" else match.of_proposed for who in pair)
        try:
            found = _paid(records, own[0], cells)
        except Unscored as unscored:
            if pair in (BB, KK):
                return {}, {manner: str(unscored)}
            missing = str(unscored)
        else:
            values[pair] = found
    known = values if missing is None else {pair: values[pair] for pair in (BB, KK)}
    return {manner: split_returns(known, match.seeds, None, missing)}, {}


def _paid(records: Records, own: Cell, cells: Sequence[Cell]) -> list[float]:
    """What the reward of a cell pays for an evaluation episode of each cell, mean over episodes.

    Raises:
        Unscored: It cannot pay, or has changed, or no episode ended.
    """
    payer, taught = records.payer(own.reward), records.of(own)
    payer.require_unchanged(taught.pays_recorded(payer, EVALUATION))
    found = []
    for cell in cells:
        value = records.of(cell).evaluation_return(payer)
        records.of(cell).finish()
        if value is None:
            raise Unscored(f"no episode ended in the evaluation of seed {cell.seed}")
        found.append(value)
    return found


def _score(records: Records, match: _Match) -> tuple[dict[Pair, GroupCurve], str | None]:
    """The curves of both trainings under both rewards; if that fails, under their own rewards, with the reason."""
    curves = {pair: _curve(records, match, pair) for pair in (BB, KK)}
    try:
        curves |= {pair: _curve(records, match, pair) for pair in (BK, KB)}
    except Unscored as unscored:
        return curves, str(unscored)
    return curves, None


def _curve(records: Records, match: _Match, pair: Pair) -> GroupCurve:
    """S_r(tau_q) of one pair (r, q)."""
    (own, *_), cells = (match.of_baseline if who == "baseline" else match.of_proposed for who in pair)
    return records.curve(cells) if pair[0] == pair[1] else _scored_curve(records, own, cells)


def _scored_curve(records: Records, own: Cell, cells: Sequence[Cell]) -> GroupCurve:
    """The trainings of `cells` paid by the reward that taught `own`."""
    payer, taught = records.payer(own.reward), records.of(own)
    is_unchanged = taught.pays_recorded(payer)
    taught.finish()
    payer.require_unchanged(is_unchanged)
    return records.curve_paid_by(payer, cells)


class _CurvesOnDemand(Mapping[Pair, GroupCurve]):
    """The curves of a comparison. They are read again at each request, because all curves would fill the memory."""

    def __init__(self, records: Records, match: _Match, pairs: tuple[Pair, ...]) -> None:
        self._records, self._match, self._pairs = records, match, pairs

    def __getitem__(self, pair: Pair) -> GroupCurve:
        if pair not in self._pairs:
            raise KeyError(pair)
        return _curve(self._records, self._match, pair)

    def __iter__(self) -> Iterator[Pair]:
        return iter(self._pairs)

    def __len__(self) -> int:
        return len(self._pairs)


class _Measures:
    """Every measure of one comparison."""

    def __init__(self, records: Records, match: _Match, swaps: Swaps) -> None:
        self._records, self._match, self._swaps = records, match, swaps
        self._one, self._other = (
            [records.measured(cell) for cell in cells] for cells in (match.of_baseline, match.of_proposed)
        )
        self._manifest = records.manifest(match.of_baseline[0])
        self.episodes = _fewest_episodes([*self._one, *self._other])
        """The number of episodes in each manner that all cells have, as in the cell with the fewest."""

    def changes(self) -> tuple[Change, ...]:
        """The measures of the trained policies in each manner, of the trainings, and of how fast they learned."""
        random = [it.random for it in (*self._one, *self._other)]
        found = [
            self._change(
                self._measure(name, manner, episodes),
                [it.manners[manner][name] for it in self._one],
                [it.manners[manner][name] for it in self._other],
                [values[name] for values in random],
            )
            for manner, episodes in self.episodes.items()
            for name in self._records.metrics
        ]
        return (*found, *self._learning()) if self._match.group.evaluate_every else tuple(found)

    def along(self) -> tuple[StepChange, ...]:
        """The deciding measures at each evaluation before the end of the trainings."""
        if not self._match.group.evaluate_every:
            return ()
        names = [name for name in DECIDING if name in self._records.metrics]
        episodes = next(iter(self.episodes.values()))  # of the cells' own manner

        def change(name: str, manner: str, *sides: Sequence[float | None]) -> Change:
            return self._change(self._measure(name, manner, episodes), *sides)

        return changes_along(self._match.group, self._moments, names, change)

    def _learning(self) -> list[Change]:
        return learning_changes(self._match.group, self._moments, SUCCESS, self._change)

    @cached_property
    def _moments(self) -> Moments:
        one, other = (
            [self._records.moments(cell) for cell in cells]
            for cells in (self._match.of_baseline, self._match.of_proposed)
        )
        return one, other

    def _measure(self, name: str, manner: str, episodes: int) -> Measure:
        return measure_of(name, self._records.metrics[name], manner, episodes, self._manifest)

    def _change(
        self,
        measure: Measure,
        baseline: Sequence[float | None],
        proposed: Sequence[float | None],
        random: Sequence[float | None] = (),
    ) -> Change:
        seeds = self._match.seeds
        one, other = (dict(zip(seeds, given, strict=True)) for given in (baseline, proposed))
        reasons = [it.reasons[measure.name] for it in (*self._one, *self._other) if measure.name in it.reasons]
        return replace(change_of(measure, one, other, self._swaps, random), reason=next(iter(reasons), ""))


def _fewest_episodes(measured: Sequence[Measured]) -> dict[str, int]:
    """The fewest episodes by manner. A manner that some cell lacks, such as a cell of version 0.1, is left out."""
    return {
        manner: min(it.episodes[manner] for it in measured)
        for manner in measured[0].manners
        if all(manner in it.manners for it in measured)
    }
