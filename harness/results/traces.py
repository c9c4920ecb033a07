"""The traces of an arm's done cells, as results and comparisons ask about them."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import combinations
from typing import Any, Literal

import numpy as np

from harness.arrays import Float
from harness.errors import NewerFormat, SchemaError, Unscored
from harness.eta.behaviour_change import Quantity
from harness.eta.curve import GroupCurve, stream_curve
from harness.eta.headline import DECIDING, SUCCESS
from harness.eta.interval import SHARE
from harness.eta.manner import DETERMINISTIC, OWN_AND_OTHER, STOCHASTIC, TRAINING
from harness.eta.scored_sums import Pair
from harness.measure import Measure, bounds_of, is_share
from harness.record.cell import Cell
from harness.record.cell_folder import REMEDY
from harness.record.folder import EVALUATION, RANDOM, TRACE
from harness.record.manifest import Manifest
from harness.registry.choice import Choice
from harness.results.by_term import ByTerm
from harness.results.cell_results import PAID, CellResults, Floors
from harness.results.compare import compare_all
from harness.results.comparison import Comparison, Group
from harness.results.done_cells import DoneCells
from harness.results.learning import Learning, LearningCurve, LearningRun, learning_points, mean_point, stretches
from harness.results.measured import Counted, Measured, Mixture, Moment, Values, mixtures_of
from harness.results.metrics import measure_of
from harness.results.records import Records
from harness.results.return_matrix import ReturnMatrix, return_matrices
from harness.results.table import Numbers, numbers_of
from harness.results.trainings import Ends, Match, TermsOfTraining
from harness.results.verdicts import Seen
from harness.score.installed_reward import InstalledReward


class Traces:
    """What the cells of an arm left."""

    subject = "robot"
    notes: Sequence[str] = ()
    said: Sequence[str] = ()
    damaged: Sequence[str] = ()

    def __init__(self, records: Records, metrics: Iterable[str] | None = None) -> None:
        """Read nothing yet.

        Args:
            records: What the folder of the experiment says of its cells.
            metrics: Which metrics; see `harness.results.metrics.load_metrics`.

        Raises:
            UsageError: A named metric is not registered.
            PluginError: A named metric is broken.
        """
        self.records = records
        self._measured: dict[str, Measured] = {}
        self._moments: dict[str, tuple[Moment, ...]] = {}
        self._found: dict[str, CellResults] = {}
        self._curves: dict[tuple[str, ...], GroupCurve] = {}
        self._cells = DoneCells(records.store, records.registry, metrics, records.named)

    @property
    def metrics(self) -> Mapping[str, Measure]:
        """Every registered metric, or those that were chosen, by name."""
        return self._cells.metrics

    @property
    def measures(self) -> tuple[str, ...]:
        """The names of all of them."""
        return tuple(self.metrics)

    @property
    def trainings(self) -> "list[TraceTrainings]":
        """Those that are done, by group."""
        return [TraceTrainings(self, group) for group in self.records.groups]

    @property
    def comparisons(self) -> tuple[Comparison, ...]:
        """Each reward against the baseline, or every two; also in a group in which nothing is done yet."""
        records = self.records
        of_group = [(TraceTrainings(self, group), one, other) for group, one, other in _asked(records)]
        asked = [(trainings, trainings.match(one, other)) for trainings, one, other in of_group]
        seen = Seen.of(records.manifests, records.plan.terms.looks)
        seeds = {seed for _, match in asked for of in match.seeds_of for seed in of}
        return compare_all(asked, seeds, records.plan.terms, seen.look_of, seen.to_come)

    @property
    def returns(self) -> tuple[ReturnMatrix, ...]:
        """See `Results`; scored by every reward of the experiment."""
        records = self.records
        scoring = dict.fromkeys(it.cell.reward for it in records.manifests if it.status != "skipped")
        groups: dict[Group, dict[Choice, list[CellResults]]] = {}
        for cell in sorted(records.done_cells, key=lambda cell: cell.seed):
            groups.setdefault(Group.of(cell), {}).setdefault(cell.reward, []).append(self.of(cell))
        return return_matrices(list(scoring), groups, self.installed)

    def examine(self, manifest: Manifest) -> Manifest:
        """What there is to say of a cell. Files that are what was written may still hold what no cell can have done."""
        if manifest.status != "done":
            return manifest
        try:
            found = self._found[manifest.cell.id] = self._cells.of(manifest)
            found.require_plausible()
        except NewerFormat:
            raise
        except SchemaError as error:
            return Manifest(manifest.cell, status="damaged", reason=f"{error}; {REMEDY}")
        return manifest

    def numbers(self, cell: Cell) -> Numbers:
        return numbers_of(self.measured(cell), self.metrics)

    def frames(self, cell: Cell, episode: int = 0) -> None:
        return

    def older_keys(self) -> dict[str, Any]:
        return {}

    def measured(self, cell: Cell) -> Measured:
        """Every metric of a done cell."""
        if cell.id not in self._measured:
            found = self.of(cell)
            self._measured[cell.id] = found.measured({**dict.fromkeys(self.metrics), **self._floors.of(cell)})
            if found.has_read:
                found.keep_own()  # columns are there now
            found.finish()
        return self._measured[cell.id]

    def floor_returns(self, cell: Cell, reward: InstalledReward) -> Float:
        """What a reward pays each episode of random actions where a done cell trained, (episodes,); see `Floors`."""
        return self._floors.returns(cell, reward)

    def moments(self, cell: Cell) -> tuple[Moment, ...]:
        """Every evaluation of a done cell during its training, and the one after it."""
        if cell.id not in self._moments:
            self._moments[cell.id] = self.of(cell).moments()
            self.of(cell).finish()
        return self._moments[cell.id]

    def learned(self, cell: Cell) -> Float:
        """The finished episodes of a done cell's training, (3, episodes); see `CellResults.learned`."""
        learned = self.of(cell).learned()
        self.of(cell).finish()
        return learned

    def recorded(self, cell: Cell) -> Float:
        """What a done cell's own reward paid, every row of its training, (rows,)."""
        return self.of(cell).recorded()

    def of(self, cell: Cell) -> CellResults:
        """The results of a done cell."""
        if cell.id not in self._found:
            self._found[cell.id] = self._cells.of(self.records.manifest(cell))
        return self._found[cell.id]

    def installed(self, choice: Choice) -> InstalledReward:
        """What pays recorded runs again by a reward."""
        return self._cells.installed(choice)

    def floor_of(self, cell: Cell) -> Cell | None:
        """The cell that evaluated random actions in the place of a done cell; None if no cell did."""
        return self._floors.owner(cell)

    def curve(self, cells: Sequence[Cell]) -> GroupCurve:
        """The curve of done cells' trainings, as they were paid. It is kept, since many rewards share one baseline."""
        key = tuple(cell.id for cell in cells)
        found = self._curves.pop(key, None) or self._curve(cells, lambda of: of.recorded())
        self._curves = {**dict(list(self._curves.items())[-1:]), key: found}  # only the last two are kept
        return found

    def curve_paid_by(self, reward: InstalledReward, cells: Sequence[Cell]) -> GroupCurve:
        """The curve of done cells' trainings, as another reward would have paid them.

        Raises:
            Unscored: It cannot.
        """
        return self._curve(cells, lambda of: of.paid_by(reward))

    @cached_property
    def _floors(self) -> Floors:
        return Floors(self.records.store, self.records.manifests, self.of)

    def _curve(self, cells: Sequence[Cell], rewards: Callable[[CellResults], Float]) -> GroupCurve:
        """The curve of cells. Only one run at a time is in memory."""
        rows = min(self.of(cell).rows() for cell in cells)
        return stream_curve(self._runs(cells, rewards), len(cells), rows, self.records.kind)

    def _runs(self, cells: Sequence[Cell], rewards: Callable[[CellResults], Float]) -> Iterator[Float]:
        for cell in cells:
            yield rewards(self.of(cell))
            self.of(cell).finish()


class TraceTrainings:
    """The trainings of an arm in one group, by their traces; see `harness.results.trainings.Trainings`."""

    number_of: Literal["returns", "indices"] = "indices"
    counted: Mapping[str, Counted] = {}

    def __init__(self, traces: Traces, group: Group) -> None:
        records = traces.records
        self._traces, self._records, self.group, self.names = traces, records, group, tuple(traces.metrics)
        self._cells = records.groups.get(group, [])
        self.averaged = records.plan.terms.averaged
        self.baseline, self.leading = records.baseline, records.named or DECIDING
        self.deciding = records.named[:1] or DECIDING
        shares = (name for name in self.deciding if name in traces.metrics and is_share(traces.metrics[name]))
        self.success = next(shares, SUCCESS)

    def match(self, label: str, proposed: Choice) -> Match[Cell]:
        """The trainings of a reward, and those of another one; of the baseline and itself those of the null control."""
        records, members = self._records, self._cells
        baseline = {cell.seed: cell for cell in members if cell.reward.label == label}
        of_control = records.plan.control if label == records.baseline else {}
        control = {seed: baseline[other] for seed, other in of_control.items() if other in baseline}
        other = control if proposed.label == label else {it.seed: it for it in members if it.reward == proposed}
        of_plan = {seed: cell for seed, cell in baseline.items() if not records.is_control(cell)}
        return Match.of_seeds((label, proposed.label), of_plan, other, control)

    def decided_in(self, episodes: Mapping[str, int]) -> str:
        return ""

    def measured(self, training: Cell) -> Measured:
        return self._traces.measured(training)

    def moments(self, training: Cell) -> Sequence[Moment]:
        return self._traces.moments(training)

    def measure(self, name: str, manner: str, episodes: int) -> Quantity:
        manifest = self._records.manifest(self._cells[0])
        return measure_of(name, self._traces.metrics[name], manner, episodes, manifest)

    def has_floor(self, manner: str) -> bool:
        """See `Trainings`: beside everything that metrics measured; nobody measured how random actions learn."""
        return manner in (DETERMINISTIC, STOCHASTIC, TRAINING)

    def reason(self, match: Match[Cell], name: str, manner: str) -> str:
        reasons = (self._traces.measured(cell).reasons for side in match.sides for cell in side)
        return next((it[name] for it in reasons if name in it), "")

    def curve(self, match: Match[Cell], pair: Pair) -> GroupCurve:
        own, cells = match.of(pair[0])[0], match.of(pair[1])
        if pair[0] == pair[1]:
            return self._traces.curve(cells)
        reward, taught = self._traces.installed(own.reward), self._traces.of(own)
        is_unchanged = taught.pays_recorded(reward)
        taught.finish()
        reward.require_unchanged(is_unchanged)
        return self._traces.curve_paid_by(reward, cells)

    def control(self, match: Match[Cell]) -> GroupCurve | None:
        return self._traces.curve(match.control) if match.control else None

    def return_manners(self, episodes: Mapping[str, int]) -> Sequence[str]:
        """See `Trainings`: the final evaluation alone."""
        return [*OWN_AND_OTHER[self.group.deterministic][:1]]

    def returned(self, match: Match[Cell], pair: Pair, manner: str) -> list[float]:
        """See `Trainings`: of an episode, its events left out."""
        own, found = match.of(pair[0])[0], []
        reward, taught = self._traces.installed(own.reward), self._traces.of(own)
        reward.require_unchanged(taught.pays_recorded(reward, EVALUATION))
        for cell in match.of(pair[1]):
            value = self._traces.of(cell).evaluation_return(reward)
            self._traces.of(cell).finish()
            if value is None:
                raise Unscored(f"no episode ended in the evaluation of seed {cell.seed}")
            found.append(value)
        return found

    def paid_beside_random(self, trainings: Sequence[Cell]) -> tuple[list[float], Float]:
        """See `Trainings`: of an episode, its events included, which the training maximised too."""
        first, paid = trainings[0], []
        reward, taught = self._traces.installed(first.reward), self._traces.of(first)
        reward.require_unchanged(taught.pays_recorded(reward, EVALUATION))
        for cell in trainings:
            value = self._traces.of(cell).evaluation_paid()
            self._traces.of(cell).finish()
            if value is None:
                raise Unscored(f"no episode ended in the evaluation of seed {cell.seed}")
            paid.append(value)
        return paid, self._traces.floor_returns(first, reward)

    def same_steps(self, match: Match[Cell]) -> bool:
        """See `Trainings`; evaluations are read only if every measure of every seed is the same."""
        pairs = list(zip(match.of_baseline, match.of_proposed, strict=True))
        if any(self.measured(one).manners != self.measured(other).manners for one, other in pairs):
            return False
        return all(self._motion(one) == self._motion(other) for one, other in pairs)

    def _motion(self, cell: Cell) -> str:
        found = self._traces.of(cell)
        motion = found.motion()
        found.finish()
        return motion

    def mixtures(self, match: Match[Cell]) -> tuple[Mixture, ...]:
        one, other = match.sides
        cells = dict.fromkeys([*one, *other, *match.control])
        return mixtures_of(map(self._records.manifest, cells))

    def rescaling(self, match: Match[Cell]) -> None:
        """See `Trainings`: an arm's rewards say it by the splits."""
        return

    def same_starts(self, match: Match[Cell]) -> bool:
        """See `Trainings`: equal seeds meet equal starts and targets."""
        return True

    @cached_property
    def _taught(self) -> dict[str, list[Cell]]:
        """The cells by their reward, in the order of their seeds."""
        found: dict[str, list[Cell]] = {}
        for cell in sorted(self._cells, key=lambda cell: cell.seed):
            if not self._records.is_control(cell):
                found.setdefault(cell.reward.label, []).append(cell)
        return found

    @property
    def rewards(self) -> Sequence[str]:
        return list(self._taught)

    @property
    def is_alone(self) -> bool:
        """See `Trainings`: as planned."""
        planned = (it.cell for it in self._records.manifests if it.status != "skipped")
        rewards = {cell.reward.label for cell in planned if Group.of(cell) == self.group}
        return len(rewards) == 1 and not self._records.plan.control

    def members(self, reward: str) -> Sequence[Cell]:
        return self._taught.get(reward, [])

    def learning(self, comparison: Comparison) -> Learning:
        """See `Trainings`: of evaluations, or where there are none before the end of the training itself."""
        sides = [
            (reward, [next(cell for cell in self.members(reward) if cell.seed == seed) for seed in seeds])
            for reward, seeds in zip((comparison.baseline, comparison.proposed), comparison.trained, strict=True)
        ]
        if self.group.evaluate_every:
            baseline, proposed = (self._evaluated(*side) for side in sides)
            if any(len(run.moments) > 1 for curve in (baseline, proposed) for run in curve.runs):
                random = {it.name: it.random for it in comparison.measured.changes_of(comparison.own_manner)}
                return Learning(baseline, proposed, random)
        baseline, proposed = (self.learned(*side) for side in sides)
        return Learning(baseline, proposed, dict.fromkeys(baseline.points))

    def _evaluated(self, reward: str, cells: Sequence[Cell]) -> LearningCurve:
        runs = tuple(LearningRun(cell.seed, self._traces.moments(cell)) for cell in cells)
        points = {
            name: learning_points(runs, name, self.group, is_share(metric), bounds_of(metric))
            for name, metric in self._traces.metrics.items()
        }
        return LearningCurve(reward, runs, points)

    def learned(self, reward: str, members: Sequence[Cell]) -> LearningCurve:
        """See `Trainings`: success, and what the reward paid, of the episodes that ended in each stretch."""
        learned = [self._traces.learned(cell) for cell in members]
        success, paid = [], []
        for begin, end in stretches(self.group.steps):
            ended = [it[1:, slice(*np.searchsorted(it[0], [begin, end]))] for it in learned]
            means = [it.mean(axis=1).tolist() if it.shape[1] else (None, None) for it in ended]
            fewest = min(it.shape[1] for it in ended)
            success.append(mean_point(end, [it[0] for it in means], fewest or None, SHARE))
            paid.append(mean_point(end, [it[1] for it in means]))
        return LearningCurve(reward, (), {SUCCESS: tuple(success), PAID: tuple(paid)})

    def pay_name(self, reward: str) -> str:
        return PAID

    def ends(self, training: Cell) -> Ends:
        found = self._traces.of(training)
        start, end, count = found.ends()
        measured = self._traces.measured(training)
        evaluated = {**measured.own, PAID: found.recorded_return(EVALUATION)}
        found.finish()
        return Ends(start, end, evaluated, (count, next(iter(measured.episodes.values()))))

    def at_random(self, reward: str) -> Values:
        """See `Trainings`: pay where a cell of the reward recorded it."""
        first = self.members(reward)[0]
        values, owner = self._traces.measured(first).random, self._traces.floor_of(first)
        if owner is None or owner.reward != first.reward:
            return values
        found = self._traces.of(owner)
        paid = found.recorded_return(RANDOM)
        found.finish()
        return {**values, PAID: paid}

    def has_terms(self, reward: str) -> bool:
        """See `Trainings`: whether its trainings recorded some."""
        return any(self._traces.of(cell).term_names() for cell in self.members(reward))

    def terms_paid(self, reward: str) -> list[TermsOfTraining]:
        files = (TRACE, EVALUATION)
        return [TermsOfTraining(*(self._terms(cell, cell.reward, it) for it in files)) for cell in self.members(reward)]

    def terms_beside(self, reward: str, trained: str) -> tuple[list[TermsOfTraining], str]:
        """See `Trainings`: the evaluations."""
        choice, cells = self.members(reward)[0].reward, self.members(trained)
        try:
            return [TermsOfTraining(None, self._terms(cell, choice, EVALUATION)) for cell in cells], ""
        except Unscored as unscored:
            return [], str(unscored)

    def terms_at_random(self, reward: str) -> ByTerm | None:
        first = self.members(reward)[0]
        owner = self._traces.floor_of(first)
        try:
            return None if owner is None else self._terms(owner, first.reward, RANDOM)
        except Unscored:
            return None

    def _terms(self, cell: Cell, choice: Choice, file: str) -> ByTerm:
        found = self._traces.of(cell)
        try:
            return found.terms_paid(self._traces.installed(choice), file)
        finally:
            found.finish()


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
