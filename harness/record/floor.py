"""Random actions, evaluated once: the floor that all policies of a simulator, task and robot are held against."""

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple, Self

from harness.record.cell import Cell
from harness.record.cell_folder import is_named
from harness.record.folder import RANDOM, recording_of
from harness.record.manifest import Ending, Manifest
from harness.record.store import Store
from harness.registry.choice import Choice


class Floor(NamedTuple):
    """All that decides what random actions do in an evaluation, but for what they are paid."""

    simulator: Choice
    robot: str
    task: Choice
    episodes: int
    horizon: int

    @classmethod
    def of(cls, cell: Cell) -> Self:
        """The floor of a cell."""
        return cls(cell.simulator, cell.robot, cell.task, cell.evaluation_episodes, cell.evaluation_horizon)


def has_floor(files: Path, record: Ending) -> bool:
    """Whether a cell, in this folder, evaluated random actions."""
    is_there = (files / RANDOM).is_file() or (files / recording_of(RANDOM)).is_dir()
    return is_there and (is_named(record, RANDOM) or is_named(record, recording_of(RANDOM)))


def floors_in(manifests: Iterable[Manifest], store: Store) -> dict[Floor, Cell]:
    """The floors that are there, each with the first done cell that evaluated it; cells of version 0.1 all did.

    Args:
        manifests: Of cells of the experiment; those that are not done are left out.
        store: Its folder.
    """
    found: dict[Floor, Cell] = {}
    for manifest in manifests:
        if manifest.status == "done" and has_floor(store.cell_folder(manifest.cell), manifest):
            found.setdefault(Floor.of(manifest.cell), manifest.cell)
    return found
