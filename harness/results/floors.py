"""What metrics say of random actions: each floor is measured once, for all cells that share it."""

from collections.abc import Iterable

from harness.record.cell import Cell
from harness.record.floor import Floor, floors_in
from harness.record.manifest import Manifest
from harness.record.store import Store
from harness.results.done_cells import DoneCells
from harness.results.measured import Values


class Floors:
    """Of the cells in an experiment's folder."""

    def __init__(self, store: Store, cells: DoneCells, manifests: Iterable[Manifest]) -> None:
        """Read nothing yet.

        Args:
            store: The folder.
            cells: Measures them.
            manifests: Of its cells.
        """
        self._cells = cells
        self._manifests = {manifest.cell.id: manifest for manifest in manifests}
        self._owners = floors_in(self._manifests.values(), store)
        self._values: dict[str, Values] = {}

    def of(self, cell: Cell) -> Values:
        """Every metric of random actions in the simulator, task and robot of a done cell; None where none did them."""
        own = self._cells.of(self._manifests[cell.id])
        owner = cell if own.has_floor else self._owners.get(Floor.of(cell))
        if owner is None:
            return dict.fromkeys(self._cells.metrics)
        if owner.id not in self._values:
            found = self._cells.of(self._manifests[owner.id])
            self._values[owner.id] = found.floor()
            found.finish()
        return self._values[owner.id]
