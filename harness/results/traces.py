"""The done cells of arms as trainings that are compared: what their traces say, each thing computed once."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from itertools import combinations
from typing import Any, TypeVar

import numpy as np

from harness.arrays import Float
from harness.errors import NewerFormat, SchemaError, Unscored
from harness.eta.behaviour_change import Quantity
from harness.eta.headline import DECIDING, SUCCESS
from harness.eta.seed_mean import SeedMean, mean_over_seeds
from harness.measure import Measure, is_share
from harness.record.cell import Cell
from harness.record.folder import EVALUATION, RANDOM, TRACE
from harness.record.manifest import REMEDY, Manifest
from harness.registry.choice import Choice
from harness.results.by_term import ByTerm
from harness.results.cell_results import CellResults, Floors
from harness.results.comparison import Group
from harness.results.done_cells import DoneCells
from harness.results.measured import Measured, Moment
from harness.results.metrics import measure_of
from harness.results.recordings.episodes import Part
from harness.results.records import Records
from harness.results.return_matrix import ReturnMatrix
from harness.results.table import Numbers, numbers_of
from harness.results.trainings import Match, Trained, Trainings
from harness.score.installed_reward import InstalledReward

Told = TypeVar("Told")
EVENTS, UNFINISHED = "", "no finished episode in some seeds"
FILES = {"training": TRACE, "evaluation": EVALUATION}


class CellRun:
    """A done cell of an arm; see `Run`. What it reads it lets go of."""

    def __init__(self, traces: "Traces", cell: Cell) -> None:
        self._traces, self.cell = traces, cell
        self.seed, self.reward, self.manifest = cell.seed, cell.reward.label, traces.records.manifest(cell)

    def ask(self, question: Callable[[CellResults], Told]) -> Told:
        """What its files say."""
        found = self._traces.of(self.cell)
        try:
            return question(found)
        finally:
            found.finish()

    @property
    def cut(self) -> int:
        return self.ask(CellResults.rows)

    @cached_property
    def measured(self) -> Measured:
        floor = {**dict.fromkeys(self._traces.metrics), **self._traces.floors.of(self.cell)}

        def measure(found: CellResults) -> Measured:
            measured = found.measured(floor)
            if found.has_read:
                found.keep_own()  # columns are there now
            return measured

        return self.ask(measure)

    @cached_property
    def moments(self) -> Sequence[Moment]:
        return self.ask(CellResults.moments)

    def reason(self, name: str, manner: str) -> str:
        return self.measured.reasons.get(name, "")

    def stretch(self, begin: int, end: int) -> Part:
        """See `Run`: success and pay."""
        ended, reached, paid = self._learned
        inside = slice(*np.searchsorted(ended, [begin, end]))
        success, pay = (float(of[inside].mean()) if len(of[inside]) else None for of in (reached, paid))
        return Part(len(paid[inside]), {self.reward: pay}, {SUCCESS: success}, {})

    @cached_property
    def _learned(self) -> Float:
        return self.ask(CellResults.learned)

    def on_the_way(self, every: int) -> Mapping[int, Part]:
        return {}

    def ends(self) -> tuple[Part, Part, Part]:
        measured, pay = self.measured, self.ask(lambda it: it.recorded_return("return"))
        evaluated = Part(next(iter(measured.episodes.values())), {self.reward: pay}, measured.own, {})
        return (*self.ask(CellResults.ends), evaluated)

    def paid(self, by: Any) -> Float:
        """See `Run`: its own reward's pay is recorded."""
        if by.reward == self.reward:
            return self.ask(CellResults.recorded)
        reward = self._traces.unchanged(by, TRACE)
        return self.ask(lambda it: it.paid_by(reward))

    def returned(self, by: Any, manner: str) -> float:
        """See `Run`: its events left out."""
        reward = self._traces.unchanged(by, EVALUATION)
        return self._known(self.ask(lambda it: it.evaluation_return(reward)))

    def final_pay(self) -> float:
        """See `Run`: its events included."""
        return self._known(self.ask(lambda it: it.recorded_return("paid")))

    def random_pay(self) -> Float:
        return self._traces.floor_returns(self.cell, self._traces.unchanged(self, EVALUATION))

    def _known(self, value: float | None) -> float:
        if value is None:
            raise Unscored(f"no episode ended in the evaluation of seed {self.seed}")
        return value

    def at_random(self) -> Part:
        """See `Run`: pay where a cell of the reward recorded it."""
        owner = self._random
        is_own = owner is not None and owner.reward == self.reward
        pay = owner.ask(lambda it: it.recorded_return("return", RANDOM)) if owner is not None and is_own else None
        return Part(0, {self.reward: pay}, self.measured.random, {})

    @property
    def _random(self) -> "CellRun | None":
        owner = self._traces.floors.owner(self.cell)
        return self._traces.run(owner) if owner else None

    @property
    def has_terms(self) -> bool:
        """See `Run`: whether its training recorded some."""
        return bool(self._traces.of(self.cell).term_names())

    def terms(self, by: Any, part: str) -> ByTerm | None:
        """See `Run`: what others pay its training is not asked for."""
        reward = self._traces.installed(by.cell.reward)
        if part != "random":
            is_asked = part != "training" or by.reward == self.reward
            return self.ask(lambda it: it.terms_paid(reward, FILES[part])) if is_asked else None
        try:
            return self._random.ask(lambda it: it.terms_paid(reward, RANDOM)) if self._random else None
        except Unscored:
            return None

    def motion(self) -> str:
        return self.ask(CellResults.motion)


class Traces:
    """What the cells of an arm left."""

    subject = "robot"

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
        self._cells = DoneCells(records.store, records.registry, metrics, records.named)
        self.installed = self._cells.installed
        self._found: dict[str, CellResults] = {}
        self._runs: dict[str, CellRun] = {}
        self._pays: dict[tuple[str, str], bool] = {}

    @property
    def metrics(self) -> Mapping[str, Measure]:
        """Every registered metric, or those that were chosen, by name."""
        return self._cells.metrics

    @cached_property
    def trainings(self) -> list[Trainings]:
        """Those that are done, by group."""
        return list(map(self._of_group, self.records.groups))

    @property
    def _planned(self) -> list[Cell]:
        return [it.cell for it in self.records.manifests if it.status != "skipped"]

    def _of_group(self, group: Group) -> Trainings:
        records, metrics = self.records, self.metrics
        cells = sorted(records.groups.get(group, []), key=lambda cell: cell.seed)
        planned = {cell.reward for cell in self._planned if Group.of(cell) == group}
        baseline = {cell.seed: self.run(cell) for cell in cells if cell.reward.label == records.baseline}
        deciding = records.named[:1] or DECIDING

        def quantity(name: str, manner: str, episodes: int) -> Quantity:
            return measure_of(name, metrics[name], manner, episodes, records.manifest(cells[0]))

        return Trainings(
            group,
            records.baseline,
            {(cell.reward.label, cell.seed): self.run(cell) for cell in cells if not records.is_control(cell)},
            tuple(metrics),
            quantity,
            records.kind,
            deciding,
            records.named or DECIDING,
            next((name for name in deciding if name in metrics and is_share(metrics[name])), SUCCESS),
            records.plan.terms.averaged,
            {seed: baseline[other] for seed, other in records.plan.control.items() if other in baseline},
            is_alone=len(planned) == 1 and not records.plan.control,
        )

    @property
    def asked(self) -> list[tuple[Trainings, Match]]:
        """Each reward of the plan with the baseline, or every two; also in a group in which nothing is done yet."""
        records = self.records
        planned = dict.fromkeys((Group.of(cell), cell.reward.label) for cell in self._planned)
        of, first = {it.group: it for it in self.trainings}, records.baseline
        asked = [(group, first, reward) for group, reward in planned if reward != first or records.plan.a_a]
        others: dict[Group, list[str]] = {}
        for group, reward in planned if records.pairs else ():
            others.setdefault(group, []).append(reward)
        for group, rewards in others.items():
            asked += [(group, *two) for two in combinations(filter(first.__ne__, rewards), 2)]
        return [
            (trainings, trainings.match(*names))
            for group, *names in asked
            for trainings in (of.get(group) or self._of_group(group),)
        ]

    @property
    def returns(self) -> tuple[ReturnMatrix, ...]:
        """See `Results`; scored by every reward of the experiment."""
        scoring = dict.fromkeys(cell.reward for cell in self._planned)
        return tuple(self._matrix(it, scoring) for it in self.trainings)

    def _matrix(self, of: Trainings, scoring: Iterable[Choice]) -> ReturnMatrix:
        payers = {choice.label: self._payer(choice, of) for choice in scoring}
        columns = {label: self._column(of.members(label), payers) for label in payers if label in of.rewards}
        rows = {payer: {trained: column[payer] for trained, column in columns.items()} for payer in payers}
        return ReturnMatrix(
            of.group, tuple(columns), rows, {label: column[EVENTS] for label, column in columns.items()}
        )

    def _payer(self, choice: Choice, of: Trainings) -> InstalledReward | str:
        """A reward, or why it cannot pay what it paid in the experiment; one that taught nobody is not checked."""
        try:
            taught = [it for it in of.members(choice.label) if isinstance(it, CellRun)]
            return self.unchanged(taught[0], EVALUATION) if taught else self.installed(choice)
        except Unscored as unscored:
            return str(unscored)

    def _column(self, members: Iterable[Trained], payers: Mapping[str, InstalledReward | str]) -> dict[str, SeedMean]:
        """What each reward pays trainings by one, and what events paid. Each evaluation is read once."""
        why = {payer: it for payer, it in payers.items() if isinstance(it, str)}
        paid: dict[str, list[float | None]] = {payer: [] for payer in (EVENTS, *payers)}
        for found in (self.of(it.cell) for it in members if isinstance(it, CellRun)):
            paid[EVENTS].append(found.recorded_return("events"))
            for payer, it in payers.items():
                try:
                    if payer not in why and not isinstance(it, str):
                        paid[payer].append(found.evaluation_return(it))
                except Unscored as unscored:
                    why[payer] = str(unscored)
            found.finish()

        def mean(values: list[float | None]) -> SeedMean:
            known = [value for value in values if value is not None]
            return mean_over_seeds(known, None if len(known) == len(values) else UNFINISHED)

        return {
            payer: SeedMean(None, notes=(why[payer],)) if payer in why else mean(values)
            for payer, values in paid.items()
        }

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
        """See `Results`."""
        return numbers_of(self.run(cell).measured, self.metrics)

    def run(self, cell: Cell) -> CellRun:
        """A done cell as a training."""
        if cell.id not in self._runs:
            self._runs[cell.id] = CellRun(self, cell)
        return self._runs[cell.id]

    def of(self, cell: Cell) -> CellResults:
        """The results of a done cell."""
        if cell.id not in self._found:
            self._found[cell.id] = self._cells.of(self.records.manifest(cell))
        return self._found[cell.id]

    def unchanged(self, by: CellRun, file: str) -> InstalledReward:
        """The reward of a cell, which still pays what the cell recorded.

        Raises:
            Unscored: It cannot pay, or pays something else.
        """
        reward, key = self.installed(by.cell.reward), (by.cell.id, file)
        if key not in self._pays:
            self._pays[key] = by.ask(lambda it: it.pays_recorded(reward, file))
        reward.require_unchanged(self._pays[key])
        return reward

    def floor_returns(self, cell: Cell, reward: InstalledReward) -> Float:
        """What a reward pays each episode of random actions where a done cell trained, (episodes,); empty without any.

        Raises:
            Unscored: It cannot.
        """
        owner = self.floors.owner(cell)
        return self.run(owner).ask(lambda it: it.floor_returns(reward)) if owner else np.zeros(0)

    @cached_property
    def floors(self) -> Floors:
        """Random actions of all cells."""
        return Floors(self.records.store, self.records.manifests, self.of)
