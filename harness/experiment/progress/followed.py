"""Writes down what happens to an experiment's cells while an executor does them."""

import math
import time
from collections.abc import Callable, Mapping

from harness.executor import Event, OnEvent
from harness.experiment.progress.ended_cells import EndedCells
from harness.experiment.progress.trackers import Tracking
from harness.progress import RETURN, SUCCESS
from harness.record.cell import Cell
from harness.record.manifest import Manifest, read_manifest
from harness.record.running import RUNNING, Running, write_running
from harness.record.store import Store

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
