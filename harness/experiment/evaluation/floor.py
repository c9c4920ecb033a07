"""Chooses the cells that evaluate random actions, the floor for policies: one cell for all that share the floor."""

from collections.abc import Sequence

from harness.record.cell import Cell
from harness.record.floor import Floor, floors_in
from harness.record.store import Store


def floor_carriers(waiting: Sequence[Cell], store: Store) -> frozenset[Cell]:
    """The first of the waiting cells of each floor that no done cell in the folder has.

    Args:
        waiting: Cells that are going to be done, in order.
        store: The experiment's folder.
    """
    stay = [manifest for manifest in store.manifests() if manifest.cell not in set(waiting)]  # others are replaced
    there, carriers = floors_in(stay, store), dict[Floor, Cell]()
    for cell in waiting:
        floor = Floor.of(cell)
        if floor not in there:
            carriers.setdefault(floor, cell)
    return frozenset(carriers.values())
