"""What a report needs of a cell, made as the cell ends: the first report finds it."""

from contextlib import suppress

from harness.experiment.plan import Plan
from harness.record.cell import Cell
from harness.record.manifest import Manifest
from harness.record.store import Store
from harness.registry.choice import Choice
from harness.registry.registry import Registry
from harness.results.combination import Group
from harness.results.done_cells import DoneCells


class EndedCells:
    """Measures each done cell of an experiment, and pays it by the rewards that it will be compared with."""

    def __init__(self, store: Store, registry: Registry, plan: Plan) -> None:
        self._cells, self._plan = DoneCells(store, registry), plan
        self._rewards: dict[Group, dict[Choice, None]] = {}
        for cell in plan.cells:
            self._rewards.setdefault(Group.of(cell), {})[cell.reward] = None
        self._scoring = dict.fromkeys(cell.reward for cell in plan.cells)

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
