"""What a report needs of a cell, made as the cell ends: the first report finds it. The table of all cells too."""

from collections.abc import Sequence
from contextlib import suppress

from harness.experiment.plan import Plan
from harness.experiment.progress.table_so_far import TableSoFar
from harness.record.cell import Cell
from harness.record.manifest import Manifest
from harness.record.store import Store
from harness.registry.choice import Choice
from harness.registry.registry import Registry
from harness.results.combination import Group
from harness.results.done_cells import DoneCells


class EndedCells:
    """Measures each done cell of an experiment, and pays it by the rewards that it will be compared with."""

    def __init__(
        self, store: Store, registry: Registry, plan: Plan, metrics: str | Sequence[str] | None = None
    ) -> None:
        self._cells, self._plan = DoneCells(store, registry, metrics), plan
        self._rewards: dict[Group, dict[Choice, None]] = {}
        for cell in plan.cells:
            self._rewards.setdefault(Group.of(cell), {})[cell.reward] = None
        self._scoring = dict.fromkeys(cell.reward for cell in plan.cells)
        self._table = TableSoFar(store, self._cells)

    def add(self, ended: Manifest) -> None:
        """A cell has ended, whichever way.

        Raises:
            OSError: The table cannot be written.
        """
        if ended.status == "done" and not ended.cell.is_in_environment:
            self.keep(ended)
        self._table.add(ended)
        self._table.refresh()

    def refresh(self) -> None:
        """Some time has passed; see `TableSoFar.refresh`."""
        self._table.refresh()

    def finish(self) -> None:
        """No other cell will end; see `TableSoFar.write`."""
        self._table.write()

    def keep(self, done: Manifest) -> None:
        """Whatever a plugin raises here, the report will meet and tell: the run goes on."""
        with suppress(Exception):
            self._cells.keep(done, self._compared_with(done.cell), self._scoring)

    def _compared_with(self, cell: Cell) -> list[Choice]:
        """The baseline with every other reward, and those with it; in the null control with itself."""
        baseline = self._plan.baseline
        return [
            reward
            for reward in self._rewards[Group.of(cell)]
            if baseline in (reward.label, cell.reward.label) and (reward != cell.reward or self._plan.control)
        ]
