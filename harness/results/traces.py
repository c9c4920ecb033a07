"""The done cells of arms as trainings that are compared: what their traces say, each thing computed once."""

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from functools import cached_property, partial
from itertools import combinations
from pathlib import Path

from harness.arrays import Float
from harness.errors import NewerFormat, SchemaError, Unscored
from harness.eta.behaviour_change import Quantity
from harness.eta.headline import DECIDING, SUCCESS
from harness.eta.index import Estimate, mean_over_seeds
from harness.eta.laws import Account
from harness.log.measure import Measure, is_share
from harness.record.cell import REMEDY, Cell, Manifest
from harness.record.folder import EVALUATION
from harness.registry.choice import Choice
from harness.results.cell_results import CellResults, Cells
from harness.results.comparison import Group
from harness.results.metrics import measure_of
from harness.results.results import Results, ReturnMatrix
from harness.results.table import Numbers
from harness.results.trainings import Match, Trainings

UNFINISHED = "no finished episode in some seeds"


class Traces(Results):
    """What the cells of an arm left."""

    subject, in_environment = "robot", False

    @cached_property
    def cells(self) -> Cells:
        """Those that are done."""
        return Cells(self.store, self.registry, self.plan, self._chosen, self.named)

    @property
    def metrics(self) -> dict[str, Measure]:
        return self.cells.metrics

    @cached_property
    def trainings(self) -> list[Trainings]:
        return list(map(self._of_group, self.groups))

    @property
    def _planned(self) -> list[tuple[Group, Cell]]:
        return self._grouped(it for it in self.manifests if it.status != "skipped")

    def _of_group(self, group: Group) -> Trainings:
        metrics = self.metrics
        cells = sorted(self.groups.get(group, []), key=lambda cell: cell.seed)
        planned = {cell.reward for of, cell in self._planned if of == group}
        baseline = {cell.seed: self.run(cell) for cell in cells if cell.reward.label == self.baseline}
        deciding = self.named[:1] or DECIDING

        def quantity(name: str, manner: str, episodes: int) -> Quantity:
            first = self.run(cells[0])
            return measure_of(name, metrics[name], manner, episodes, first.manifest, first.longest)

        return Trainings(
            group,
            self.baseline,
            {(cell.reward.label, cell.seed): self.run(cell) for cell in cells if not self.is_control(cell)},
            tuple(metrics),
            quantity,
            self.kind,
            deciding,
            self.named or DECIDING,
            next((name for name in deciding if name in metrics and is_share(metrics[name])), SUCCESS),
            self.plan.terms.averaged,
            {seed: baseline[other] for seed, other in self.plan.control.items() if other in baseline},
            is_alone=len(planned) == 1 and not self.plan.control,
        )

    @property
    def _asked(self) -> list[tuple[Trainings, Match]]:
        """Each reward of the plan with the baseline, or every two; also in a group in which nothing is done yet."""
        planned = dict.fromkeys((group, cell.reward.label) for group, cell in self._planned)
        of, first = {it.group: it for it in self.trainings}, self.baseline
        asked = [(group, first, reward) for group, reward in planned if reward != first or self.plan.a_a]
        for two in combinations(planned, 2) if self.pairs else ():
            (group, one), (other, another) = two
            if group == other and first not in (one, another):
                asked.append((group, one, another))
        return [
            (trainings, trainings.match(*names))
            for group, *names in asked
            for trainings in (of.get(group) or self._of_group(group),)
        ]

    def _matrices(self) -> Iterator[ReturnMatrix]:
        scoring = dict.fromkeys(cell.reward for _, cell in self._planned)
        return (self._matrix(it, scoring) for it in self.trainings)

    def _matrix(self, of: Trainings, scoring: Iterable[Choice]) -> ReturnMatrix:
        members = {it.label: [run for run in of.members(it.label) if isinstance(run, CellResults)] for it in scoring}
        taught, rows = {label: runs for label, runs in members.items() if runs}, dict[str, dict[str, Estimate]]()
        for it in scoring:  # a reward that cannot pay what it paid has no row; one that taught nobody is not checked
            try:
                runs = taught.get(it.label)
                payer = runs[0].unchanged(EVALUATION) if runs else self.cells.installed(it)
                paid = partial(CellResults.evaluation_return, reward=payer)
                rows[it.label] = {label: _mean(runs, paid) for label, runs in taught.items()}
            except Unscored as unscored:
                rows[it.label] = dict.fromkeys(taught, Estimate(None, notes=(str(unscored),)))
        events = {label: _mean(runs, lambda run: run.recorded_return("events")) for label, runs in taught.items()}
        return ReturnMatrix(of.group, tuple(taught), rows, events)

    def _examine(self, cell: Cell) -> Manifest:
        """What there is to say of a cell. Files that are what was written may still hold what no cell can have done."""
        manifest = super()._examine(cell)
        if manifest.status == "done":
            try:
                self.cells.add(manifest).keep()
            except NewerFormat:
                raise
            except SchemaError as error:
                self.cells.remove(cell)
                return Manifest(cell, status="damaged", reason=f"{error}; {REMEDY}")
        return manifest

    def _counted(self, leave_out: Collection[Path]) -> Account[Manifest]:
        account = super()._counted(leave_out)
        for it in self.manifests:
            if it.status == "skipped":
                self.cells.remove(it.cell)
        return account

    def run(self, cell: Cell) -> CellResults:
        return self.cells.done[cell.id]

    def numbers(self, cell: Cell) -> Numbers:
        return self.run(cell).numbers

    def recorded(self, cell: Cell) -> Float:
        return self.run(cell).recorded


def _mean(runs: Sequence[CellResults], paid: Callable[[CellResults], float | None]) -> Estimate:
    """What trainings by one reward are paid."""
    try:
        values = list(map(paid, runs))
    except Unscored as unscored:
        return Estimate(None, notes=(str(unscored),))
    known = [value for value in values if value is not None]
    return mean_over_seeds(known, None if len(known) == len(values) else UNFINISHED)
