"""Computes what a report needs of a cell when the cell ends, and writes the table of all cells."""

from collections.abc import Sequence
from contextlib import suppress

from harness.experiment.plan import Plan
from harness.experiment.progress.table_so_far import TableSoFar
from harness.record.cell import Cell
from harness.record.manifest import Manifest
from harness.record.store import Store
from harness.registry.choice import Choice
from harness.registry.registry import Registry
from harness.results.comparison import Group
from harness.results.done_cells import done_cells_of
from harness.results.metrics import named_measures


class EndedCells:
    """Measures each done cell of an experiment, and pays it by the rewards that it will be compared with."""

    def __init__(
        self, store: Store, registry: Registry, plan: Plan, metrics: str | Sequence[str] | None = None
    ) -> None:
        named = named_measures(plan.resolved)
        self._cells, self._plan = done_cells_of(plan.cells, store, registry, metrics, named), plan
        self._rewards: dict[Group, dict[Choice, None]] = {}
        for cell in plan.cells:
            self._rewards.setdefault(Group.of(cell), {})[cell.reward] = None
        self._scoring = dict.fromkeys(cell.reward for cell in plan.cells)
        self._table = TableSoFar(store, self._cells)

    def add(self, ended: Manifest) -> None:
        """Take in a cell that has ended, in whatever way.

        Raises:
            OSError: The table cannot be written.
        """
        if ended.status == "done":
            self.keep(ended)
        self._table.add(ended)
        self._table.refresh()

    def refresh(self) -> None:
        """Call this now and then; see `TableSoFar.refresh`."""
        self._table.refresh()

    def finish(self) -> None:
        """Call this when all cells have ended; see `TableSoFar.write`."""
        self._table.write()

    def keep(self, done: Manifest) -> None:
        """Compute what a report needs. An error of a plugin does not stop the run, because the report will show it."""
        with suppress(Exception):
            self._cells.keep(done, self._compared_with(done.cell), self._scoring)

    def _compared_with(self, cell: Cell) -> list[Choice]:
        """The rewards to compare with: the others for the baseline, the baseline for others, itself for a control."""
        baseline = self._plan.baseline
        return [
            reward
            for reward in self._rewards[Group.of(cell)]
            if baseline in (reward.label, cell.reward.label) and (reward != cell.reward or self._plan.control)
        ]
