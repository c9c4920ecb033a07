"""Writes ``results.parquet`` while cells run. Readers find in it the cells that have ended so far."""

import math
import time
from collections.abc import Callable, Mapping

from harness.metric import Metric
from harness.record.manifest import Manifest
from harness.record.store import Store
from harness.results.done_cells import DoneCells
from harness.results.floors import Floors
from harness.results.measured import Measured
from harness.results.recordings.recording_results import numbers_in_environment
from harness.results.table import Numbers, metric_columns, numbers_of, write_table

EVERY = 30.0
"""The least seconds between two tables. With many cells a table takes longer to write."""


class TableSoFar:
    """The table of an experiment while its cells end."""

    def __init__(self, store: Store, cells: DoneCells, clock: Callable[[], float] = time.monotonic) -> None:
        """Read nothing yet.

        Args:
            store: The experiment's folder.
            cells: Measures those that are done.
            clock: Tells seconds.
        """
        self._store, self._cells, self._clock = store, cells, clock
        self._measured: dict[str, tuple[Manifest, Measured | Numbers | None]] = {}
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
            write_table(self._store.folder, self._rows(), metric_columns(self._metrics))
        self._due = self._clock() + EVERY

    @property
    def _metrics(self) -> Mapping[str, Metric]:
        """Metrics know the arm alone."""
        in_environment = any(manifest.cell.is_in_environment for manifest, _ in self._measured.values())
        return {} if in_environment else self._cells.metrics

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

    def _measure(self, manifest: Manifest) -> Measured | Numbers | None:
        """All but random actions: the cell that does them may not have ended. Metrics know the arm alone."""
        if manifest.status != "done":
            return None
        if manifest.cell.is_in_environment:
            return numbers_in_environment(self._store.folder, self._store.cell_folder(manifest.cell))
        found = self._cells.of(manifest)
        measured = found.measured({})
        found.finish()
        return measured

    def _rows(self) -> list[tuple[Manifest, Numbers | None]]:
        ended = {manifest.cell: manifest for manifest, _ in self._measured.values()}
        floors = Floors(self._store, ended.values(), lambda cell: self._cells.of(ended[cell]))

        def numbers(manifest: Manifest, measured: Measured | Numbers | None) -> Numbers | None:
            if not isinstance(measured, Measured):
                return measured
            return numbers_of(measured._replace(random=floors.of(manifest.cell)), self._metrics)

        return [(manifest, numbers(manifest, measured)) for manifest, measured in self._measured.values()]
