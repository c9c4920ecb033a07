"""The done cells of arms as trainings that are compared: what their traces say, each thing computed once."""

from collections.abc import Iterable, Mapping
from functools import cached_property
from itertools import combinations

from harness.arrays import Float
from harness.errors import NewerFormat, SchemaError, Unscored
from harness.eta.behaviour_change import Quantity
from harness.eta.headline import DECIDING, SUCCESS
from harness.eta.seed_mean import SeedMean, mean_over_seeds
from harness.measure import is_share
from harness.record.cell import Cell
from harness.record.folder import EVALUATION
from harness.record.manifest import REMEDY, Manifest
from harness.registry.choice import Choice
from harness.results.cell_results import CellResults, Cells
from harness.results.comparison import Group
from harness.results.metrics import measure_of
from harness.results.records import Records
from harness.results.return_matrix import ReturnMatrix
from harness.results.table import Numbers
from harness.results.trainings import Match, Trainings
from harness.score.installed_reward import InstalledReward

EVENTS, UNFINISHED = "", "no finished episode in some seeds"


class Traces(Cells):
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
        super().__init__(records.store, records.registry, metrics, records.named)
        self.records = records

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
        taught, payers = dict[str, list[CellResults]](), dict[str, InstalledReward | str]()
        for it in scoring:  # a reward, or why it cannot pay what it paid; one that taught nobody is not checked
            runs = taught[it.label] = [run for run in of.members(it.label) if isinstance(run, CellResults)]
            try:
                payers[it.label] = runs[0].unchanged(EVALUATION) if runs else self.installed(it)
            except Unscored as unscored:
                payers[it.label] = str(unscored)
        columns = {label: _column(runs, payers) for label, runs in taught.items() if runs}
        rows = {payer: {trained: column[payer] for trained, column in columns.items()} for payer in payers}
        return ReturnMatrix(
            of.group, tuple(columns), rows, {label: column[EVENTS] for label, column in columns.items()}
        )

    def examine(self, manifest: Manifest) -> Manifest:
        """What there is to say of a cell. Files that are what was written may still hold what no cell can have done."""
        if manifest.status == "done":
            try:
                self.add(manifest).require_plausible()
            except NewerFormat:
                raise
            except SchemaError as error:
                self.remove(manifest.cell)
                return Manifest(manifest.cell, status="damaged", reason=f"{error}; {REMEDY}")
        return manifest

    def run(self, cell: Cell) -> CellResults:
        """A done cell as a training."""
        return self.done[cell.id]

    def numbers(self, cell: Cell) -> Numbers:
        """See `Results`."""
        return self.run(cell).numbers

    def recorded(self, cell: Cell) -> Float:
        """See `Results`."""
        return self.run(cell).recorded


def _column(runs: Iterable[CellResults], payers: Mapping[str, InstalledReward | str]) -> dict[str, SeedMean]:
    """What each reward pays trainings by one, and what events paid. Each evaluation is read once."""
    why = {payer: it for payer, it in payers.items() if isinstance(it, str)}
    paid: dict[str, list[float | None]] = {payer: [] for payer in (EVENTS, *payers)}
    for run in runs:
        with run:
            paid[EVENTS].append(run.recorded_return("events"))
            for payer, it in payers.items():
                try:
                    if payer not in why and not isinstance(it, str):
                        paid[payer].append(run.evaluation_return(it))
                except Unscored as unscored:
                    why[payer] = str(unscored)

    def mean(values: list[float | None]) -> SeedMean:
        known = [value for value in values if value is not None]
        return mean_over_seeds(known, None if len(known) == len(values) else UNFINISHED)

    return {
        payer: SeedMean(None, notes=(why[payer],)) if payer in why else mean(values) for payer, values in paid.items()
    }
