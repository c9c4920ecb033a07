"""What trackers are told of the cells of one run, and what they know already of those that go on."""

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from harness.executor import Event
from harness.experiment.progress.trackers import Trackers, tracked_cell
from harness.record.cell import Cell
from harness.record.running import Running
from harness.tracker import Outcome

NONE_LEFT: Mapping[str, Running] = {}


class Tracking:
    """Tells trackers each number once, also for a cell that goes on after a kill.

    Numbers wait until `pass_on`, which is called after it was written down that trackers know of them: what the last
    seconds before a kill brought is lost to the trackers, but nothing is told twice.
    """

    def __init__(
        self,
        trackers: Trackers,
        folder: Path,
        left: Mapping[str, Running] = NONE_LEFT,
        now: Callable[[], float] = time.time,
    ) -> None:
        """Begin nothing yet.

        Args:
            trackers: To be told.
            folder: Of the experiment.
            left: Cells that a killed run was doing, by id.
            now: The time, seconds since 1970.
        """
        self._trackers, self._folder, self._left, self._now = trackers, folder, left, now
        self._ids: dict[str, str] = {}  # of the tracked cell, by that of the cell
        self._known: dict[str, int] = {}  # steps that trackers knew of when the cell went on
        self._waiting: list[tuple[str, Event]] = []

    def hear(self, event: Event, running: Running) -> Running:
        """Take in the progress of a cell; returns what has to be written down."""
        if not self._trackers:
            return running
        cell = event.cell.id
        if cell not in self._ids:
            running = self._begin(event.cell, running, goes_on=event.steps > 0)
        if not event.scalars and event.steps < running.tracked:  # it went on from a checkpoint, on another machine
            self._known[cell] = running.tracked
        if event.scalars and event.steps > self._known[cell]:
            self._waiting.append((self._ids[cell], event))
            running = replace(running, tracked=max(event.steps, running.tracked))
        return running

    def pass_on(self) -> None:
        """Tell trackers what was taken in. Call this when it has been written down."""
        for tracked, event in self._waiting:
            self._trackers.log(tracked, event.steps, event.scalars)
        self._waiting.clear()

    def end(self, cell: Cell, outcome: Outcome, reason: str) -> None:
        """A cell has ended, perhaps before it told anything."""
        if self._trackers:
            if cell.id not in self._ids:
                self._begin(cell, Running(self._now()), goes_on=False)
            self._trackers.end(self._ids.pop(cell.id), outcome, reason)

    def close(self) -> None:
        """Wait for the trackers, when the run is over or interrupted."""
        for tracked in self._ids.values():
            self._trackers.end(tracked, "interrupted")
        self._ids.clear()
        self._trackers.close()

    def _begin(self, cell: Cell, running: Running, goes_on: bool) -> Running:
        left = self._left.get(cell.id)
        if goes_on and left is not None and left.track:
            running = replace(running, track=left.track, tracked=left.tracked)
        else:
            running = replace(running, track=self._now())
        tracked = tracked_cell(cell, running.track, self._folder)
        self._ids[cell.id], self._known[cell.id] = tracked.id, running.tracked
        self._trackers.begin(tracked)
        return running
