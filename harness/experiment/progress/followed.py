"""Writes down what happens to an experiment's cells while an executor does them, and what they leave when they end."""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress

from harness.errors import SchemaError
from harness.executor import Event, OnEvent
from harness.experiment.plan import Plan
from harness.experiment.progress.trackers import Tracking
from harness.progress import RETURN, SUCCESS
from harness.record.cell import Cell
from harness.record.manifest import Manifest, read_manifest
from harness.record.recording.recorded_training import recordings_in
from harness.record.running import RUNNING, Running, write_running
from harness.record.store import Store
from harness.registry.choice import Choice
from harness.registry.registry import Registry
from harness.results.cell_results import Cells
from harness.results.comparison import Group
from harness.results.metrics import named_measures
from harness.results.recordings.recording_results import RecordingResults
from harness.results.recordings.recordings import numbers_in_environment
from harness.results.table import Numbers, metric_columns, write_table


class EndedCells:
    """Measures each done cell of an experiment, and pays it by the rewards that it will be compared with."""

    def __init__(
        self, store: Store, registry: Registry, plan: Plan, metrics: str | Sequence[str] | None = None
    ) -> None:
        named = named_measures(plan.resolved)
        self._plan = plan
        in_environment = any(cell.is_in_environment for cell in plan.cells)
        self._store, self._cells = store, None if in_environment else Cells(store, registry, metrics, named)
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
            if self._cells:
                self._cells.add(done).keep(self._compared_with(done.cell), self._scoring)
                return
            for path in recordings_in(self._store.cell_folder(done.cell)):
                with suppress(SchemaError):  # the report says so
                    RecordingResults(self._store.folder, path).keep()

    def _compared_with(self, cell: Cell) -> list[Choice]:
        """The rewards to compare with: the others for the baseline, the baseline for others, itself for a control."""
        baseline = self._plan.baseline
        return [
            reward
            for reward in self._rewards[Group.of(cell)]
            if baseline in (reward.label, cell.reward.label) and (reward != cell.reward or self._plan.control)
        ]


EVERY = 30.0
"""The least seconds between two tables. With many cells a table takes longer to write."""


class TableSoFar:
    """The table of an experiment while its cells end."""

    def __init__(self, store: Store, cells: Cells | None, clock: Callable[[], float] = time.monotonic) -> None:
        """Read nothing yet.

        Args:
            store: The experiment's folder.
            cells: Measures cells of arms that are done; None in an environment.
            clock: Tells seconds.
        """
        self._store, self._cells, self._clock = store, cells, clock
        self._measured: dict[str, tuple[Manifest, Callable[[], Numbers] | None]] = {}
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
            rows = [(manifest, numbers and numbers()) for manifest, numbers in self._measured.values()]
            write_table(self._store.folder, rows, metric_columns(self._cells.metrics if self._cells else ()))
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

    def _measure(self, manifest: Manifest) -> Callable[[], Numbers] | None:
        """All but random actions: the cell that does them may not have ended."""
        if manifest.status != "done":
            return None
        if self._cells:
            found = self._cells.add(manifest)
            _ = found.policy
            return lambda: found.numbers
        told = numbers_in_environment(self._store.folder, self._store.cell_folder(manifest.cell))
        return lambda: told


NOTHING: Mapping[Cell, Manifest] = {}
WRITE_EVERY = 2.0
"""Seconds between two records of the running cells."""


class Followed:
    """Call it with every event: it completes the records in the folder and passes the event on.

    Attributes:
        failed: Cells that failed, in the order in which they ended.
    """

    def __init__(
        self,
        store: Store,
        ended: EndedCells,
        tracking: Tracking,
        on_event: OnEvent,
        again: Mapping[Cell, Manifest] = NOTHING,
        now: Callable[[], float] = time.time,
    ) -> None:
        """Start before any event.

        Args:
            store: Where the cells are.
            ended: Told of each cell that has ended.
            tracking: Told of every cell.
            on_event: Told every event, with what the cell's manifest says.
            again: Done cells that are done again, with what they say of themselves.
            now: The time, seconds since 1970.
        """
        self._store, self._ended, self._on_event, self._again, self._now = store, ended, on_event, again, now
        self._tracking = tracking
        self._running: dict[str, Running] = {}
        self._written = 0.0
        self.failed: list[Cell] = []

    def __call__(self, event: Event) -> None:
        """Take in an event of a cell."""
        if event.kind == "ended":
            event = self._end(event)
        else:
            self._ended.refresh()
            running = self._running.setdefault(event.cell.id, Running(self._now()))
            if event.kind == "progress":
                running = self._tracking.hear(event, running)
            self._running[event.cell.id] = running.after(event.steps, self._now(), **_shown(event.scalars))
        self._write(at_once=event.kind != "progress")
        self._on_event(event)

    def stop(self) -> None:
        """Call this when no cell is running any more."""
        self._tracking.pass_on()
        self._tracking.close()
        (self._store.folder / RUNNING).unlink(missing_ok=True)

    def _end(self, event: Event) -> Event:
        """The event with what the cell's manifest says; leaves a manifest for a cell that could not leave one."""
        self._tracking.pass_on()
        self._running.pop(event.cell.id, None)
        if event.reason:
            self._store.record(event.cell, "failed", event.reason, instead_of=self._again.get(event.cell))
        manifest = read_manifest(self._store.cell_folder(event.cell))
        self._ended.add(manifest)
        if manifest.status != "done":
            self.failed.append(event.cell)
        self._tracking.end(event.cell, "done" if manifest.status == "done" else "failed", manifest.reason)
        return event._replace(reason=manifest.reason, note=manifest.note)

    def _write(self, at_once: bool) -> None:
        """Write down what is running, now and then, for other processes. Trackers get it afterwards."""
        if at_once or self._now() >= self._written + WRITE_EVERY:
            self._written = self._now()
            write_running(self._store.folder, self._running)
            self._tracking.pass_on()


def _shown(scalars: Mapping[str, float]) -> dict[str, float]:
    """The numbers that ``harness status`` shows."""
    names = {"success": SUCCESS, "mean_return": RETURN}
    return {key: scalars[name] for key, name in names.items() if math.isfinite(scalars.get(name, math.nan))}
