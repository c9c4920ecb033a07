"""The metrics and returns of random actions, called floors. Each floor is measured once for all cells that share it."""

from collections.abc import Callable, Iterable

import numpy as np

from harness.arrays import Float
from harness.record.cell import Cell
from harness.record.floor import Floor, floors_in
from harness.record.manifest import Manifest
from harness.record.store import Store
from harness.results.cell_results import CellResults
from harness.results.measured import Values
from harness.score.installed_reward import InstalledReward


class Floors:
    """The floors of the cells in an experiment's folder."""

    def __init__(self, store: Store, manifests: Iterable[Manifest], of: Callable[[Cell], CellResults]) -> None:
        """Read nothing yet.

        Args:
            store: The folder.
            manifests: The manifests of its cells.
            of: A function that returns the results of a done cell.
        """
        self._of, self._owners = of, floors_in(manifests, store)
        self._values: dict[str, Values] = {}

    def of(self, cell: Cell) -> Values:
        """Every metric of random actions in a done cell's simulator, task and robot; empty if no cell has them."""
        owner = self.owner(cell)
        if owner is None:
            return {}
        if owner.id not in self._values:
            found = self._of(owner)
            self._values[owner.id] = found.floor()
            found.finish()
        return self._values[owner.id]

    def returns(self, cell: Cell, installed: InstalledReward) -> Float:
        """What a reward pays each episode of these random actions, events included, (episodes,); empty without any.

        Raises:
            Unscored: It cannot.
        """
        owner = self.owner(cell)
        if owner is None:
            return np.zeros(0)
        found = self._of(owner)
        returns = found.floor_returns(installed)
        found.finish()
        return returns

    def owner(self, cell: Cell) -> Cell | None:
        """The cell that evaluated random actions in the place of a done cell; None if no cell did."""
        return cell if self._of(cell).has_floor else self._owners.get(Floor.of(cell))
