"""Writes ``results.parquet`` while cells run. Readers find in it the cells that have ended so far."""

import math
import time
from collections.abc import Callable

from harness.record.manifest import Manifest
from harness.record.store import Store
from harness.results.done_cells import DoneCells, DoneRecordings
from harness.results.measured import Values
from harness.results.table import Numbers, write_table

EVERY = 30.0
"""The least seconds between two tables. With many cells a table takes longer to write."""


class TableSoFar:
    """The table of an experiment while its cells end."""

    def __init__(
        self, store: Store, cells: DoneCells | DoneRecordings, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Read nothing yet.

        Args:
            store: The experiment's folder.
            cells: Measures those that are done.
            clock: Tells seconds.
        """
        self._store, self._cells, self._clock = store, cells, clock
        self._measured: dict[str, tuple[Manifest, Callable[[Values], Numbers] | None]] = {}
        self._missing: dict[str, Manifest] = {}
        self._due = -math.inf

    def add(self, ended: Manifest) -> None:
        """Take in a cell that has ended. The next table has it."""
        self._missing[ended.cell.id] = ended

    def refresh(self) -> None:
        """Write the table, if the last one lacks a cell and is old enough.

        Raises:
            OSError: It cannot be written.
        """
        if self._clock() >= self._due:
            self.write()

    def write(self) -> None:
        """Write the table, if the last one lacks a cell; see `refresh`."""
        if not self._missing:
            return
        if self._can_be_read():
            write_table(self._store.folder, self._rows(), self._cells.columns)
        self._due = self._clock() + EVERY

    def _can_be_read(self) -> bool:
        """Take in what has ended; whatever a plugin raises here, the report will meet and tell: the run goes on."""
        try:
            if not self._measured:
                ended = {cell.id: self._store.examine(cell) for cell in self._store.read_plan().cells}
                self._missing = {**ended, **self._missing}
            self._measured |= {cell: (manifest, self._measure(manifest)) for cell, manifest in self._missing.items()}
        except Exception:
            return False
        self._missing.clear()
        return True

    def _measure(self, manifest: Manifest) -> Callable[[Values], Numbers] | None:
        """All but random actions: the cell that does them may not have ended."""
        return self._cells.numbers(manifest) if manifest.status == "done" else None

    def _rows(self) -> list[tuple[Manifest, Numbers | None]]:
        floor_of = self._cells.floors(manifest for manifest, _ in self._measured.values())
        return [
            (manifest, numbers and numbers(floor_of(manifest.cell))) for manifest, numbers in self._measured.values()
        ]
