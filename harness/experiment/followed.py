"""What happens to the cells of an experiment while an executor does them: written down, measured, told to trackers."""

import math
import queue
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

from harness.errors import PluginError, SchemaError, UsageError, one_line
from harness.executor import Event, OnEvent, Outcome, Track, TrackedCell, Tracker
from harness.record.cell import RUNNING, Cell, Manifest, Running, read_manifest, write_running
from harness.record.recording.recorded_training import recordings_in
from harness.record.store import Store
from harness.registry.choice import Choice, Registry, choose, split_list
from harness.results.cell_results import Cells
from harness.results.metrics import named_measures
from harness.results.recordings.recording_results import RecordingResults
from harness.results.recordings.recordings import numbers_in_environment
from harness.results.table import Numbers, metric_columns, write_table

CLOSE_WITHIN = 60.0
"""Seconds that trackers get to finish when all cells have ended."""

Given: TypeAlias = str | Mapping[str, Any]
OnTrouble: TypeAlias = Callable[[str], None]


def build_trackers(given: Given | Iterable[Given], registry: Registry) -> dict[str, Tracker]:
    """Trackers by their labels: ``"wandb:mode=offline,tensorboard"``, a table, or a list of such.

    Raises:
        UsageError: One is not known, a setting of it is not, or it cannot be used here.
        PluginError: One raises when it is asked whether it can.
    """
    items = [given] if isinstance(given, str | Mapping) else list(given)
    names = [name for item in items for name in (split_list(item) if isinstance(item, str) else [item])]
    choices = dict.fromkeys(choose(registry, "trackers", name) for name in names)
    return {choice.label: _usable(choice, registry) for choice in choices}


def _usable(choice: Choice, registry: Registry) -> Tracker:
    tracker: Tracker = choice.build(registry, "trackers")
    try:
        reason = tracker.why_not()
    except Exception as error:  # whatever a plugin raises
        raise PluginError(f"Tracker '{choice.label}' cannot say whether it can be used: {one_line(error)}") from error
    if reason:
        raise UsageError(f"Tracker '{choice.label}' cannot be used: {reason}")
    return tracker


def tracked_cell(cell: Cell, begun: float, folder: Path) -> TrackedCell:
    """A cell as trackers are told of it.

    Args:
        cell: Which.
        begun: When it was, seconds since 1970: it tells a cell that is done again from its first time.
        folder: Of the experiment.
    """
    parts = {"simulator": cell.place, "algorithm": cell.algorithm, "reward": cell.reward, "task": cell.task}
    config: dict[str, Any] = {name: part.label for name, part in parts.items()}
    config |= {
        f"{name}.{key}": value for name, part in parts.items() for key, value in part.to_json()["params"].items()
    }
    config |= {key: value for key, value in cell.to_json().items() if key not in parts}
    group = " · ".join((cell.place.label, cell.algorithm.label, cell.reward.label, cell.task.label))
    return TrackedCell(f"{cell.id}-{int(1000 * begun):x}", cell.title, group, {**config, "cell": cell.id}, folder)


class Trackers:
    """Tells each tracker in a thread of its own, so that a tracker that waits for a server delays nothing else."""

    def __init__(self, trackers: Mapping[str, Tracker], on_trouble: OnTrouble, within: float = CLOSE_WITHIN) -> None:
        """Begin nothing yet.

        Args:
            trackers: By their labels.
            on_trouble: Told in the caller's thread, once, when a tracker is switched off, and why.
            within: Seconds that they get to finish.
        """
        self._listeners = [_Listener(label, tracker) for label, tracker in trackers.items()]
        self._on_trouble, self._within = on_trouble, within

    def __bool__(self) -> bool:
        """Whether there is anybody to tell."""
        return bool(self._listeners)

    def begin(self, cell: TrackedCell) -> None:
        """A cell begins or goes on."""
        self._tell(lambda listener: listener.begin(cell))

    def log(self, cell: str, steps: int, scalars: Mapping[str, float]) -> None:
        """Numbers of a tracked cell, named by its id."""
        self._tell(lambda listener: listener.tracks[cell].log(steps, scalars))

    def end(self, cell: str, outcome: Outcome, reason: str = "") -> None:
        """A tracked cell, named by its id, has ended."""
        self._tell(lambda listener: listener.tracks.pop(cell).end(outcome, reason))

    def close(self) -> None:
        """Wait until all is told; a tracker that takes too long is left alone."""
        for listener in self._listeners:
            listener.close()
        until = time.monotonic() + self._within
        for listener in self._listeners:
            listener.wait(max(0.0, until - time.monotonic()), self._within)
        self._complain()

    def _tell(self, order: "Callable[[_Listener], None]") -> None:
        self._complain()
        for listener in self._listeners:
            listener.tell(order)

    def _complain(self) -> None:
        """Report the trackers that gave up since the last call."""
        for listener in [one for one in self._listeners if one.trouble]:
            self._listeners.remove(listener)
            self._on_trouble(f"tracker '{listener.label}' is switched off, the cells go on: {listener.trouble}")


class _Listener:
    """One tracker, and the thread that calls it.

    Attributes:
        label: Of the tracker.
        tracks: What it keeps, by the id of the cell; only its thread looks at it.
        trouble: Why it is not called any more; empty while it is.
    """

    def __init__(self, label: str, tracker: Tracker) -> None:
        self.label, self.tracks, self.trouble = label, dict[str, Track](), ""
        self._tracker = tracker
        self._orders: queue.SimpleQueue[Callable[[_Listener], None] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def begin(self, cell: TrackedCell) -> None:
        """Begin a cell, in the thread of the tracker."""
        self.tracks[cell.id] = self._tracker.begin(cell)

    def tell(self, order: "Callable[[_Listener], None]") -> None:
        """Have its thread do something."""
        self._orders.put(order)

    def close(self) -> None:
        """Tell the thread that nothing more will come."""
        self._orders.put(None)

    def wait(self, seconds: float, allowed: float) -> None:
        """Wait until its thread has done everything, for at most `seconds`. A message names the `allowed` seconds."""
        self._thread.join(seconds)
        if self._thread.is_alive():
            self.trouble = f"it has not finished within {allowed:g} s"

    def _listen(self) -> None:
        while (order := self._orders.get()) is not None:
            try:
                order(self)
            except BaseException as error:  # a library may raise anything, here SystemExit ends nothing but the thread
                self.trouble = one_line(error)
                return


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


EVERY = 30.0
"""The least seconds between two tables. With many cells a table takes longer to write."""


class EndedCells:
    """Computes what a report needs of each cell that ends, and writes the table of all that ended so far."""

    def __init__(
        self,
        store: Store,
        registry: Registry,
        metrics: str | Sequence[str] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Read nothing yet but the plan.

        Args:
            store: The experiment's folder.
            registry: The plugins, for metrics and rewards.
            metrics: Which metrics; see `harness.results.metrics.load_metrics`.
            clock: Tells seconds.
        """
        self._store, self._clock, plan = store, clock, store.read_plan()
        in_environment, named = any(cell.is_in_environment for cell in plan.cells), named_measures(plan.experiment)
        self._cells = None if in_environment else Cells(store, registry, plan, metrics, named)
        self._measured: dict[str, tuple[Manifest, Callable[[], Numbers] | None]] = {}
        self._missing: dict[str, Manifest] = {}
        self._due = -math.inf

    def add(self, ended: Manifest) -> None:
        """Take in a cell that has ended, in whatever way. The next table has it.

        Raises:
            OSError: The table cannot be written.
        """
        if ended.status == "done":
            self.keep(ended)
        self._missing[ended.cell.id] = ended
        self.refresh()

    def keep(self, done: Manifest) -> None:
        """Compute what a report needs. An error of a plugin does not stop the run, because the report will show it."""
        with suppress(Exception):
            if self._cells:
                self._cells.add(done).keep()
                return
            for path in recordings_in(self._store.cell_folder(done.cell)):
                with suppress(SchemaError):  # the report says so
                    RecordingResults(self._store.folder, path).keep()

    def refresh(self) -> None:
        """Write the table, if the last one lacks a cell and is old enough; call this now and then.

        Raises:
            OSError: It cannot be written.
        """
        if self._clock() >= self._due:
            self.write()

    def write(self) -> None:
        """Write the table, if the last one lacks a cell; see `refresh`."""
        if not self._missing:
            return
        with suppress(Exception):  # whatever a plugin raises here, the report will meet and tell: the run goes on
            if not self._measured:
                ended = {cell.id: self._store.examine(cell) for cell in self._store.read_plan().cells}
                self._missing = {**ended, **self._missing}
            self._measured |= {cell: (manifest, self._measure(manifest)) for cell, manifest in self._missing.items()}
            self._missing.clear()
        if not self._missing:
            rows = [(manifest, numbers and numbers()) for manifest, numbers in self._measured.values()]
            write_table(self._store.folder, rows, metric_columns(self._cells.metrics if self._cells else ()))
        self._due = self._clock() + EVERY

    def _measure(self, manifest: Manifest) -> Callable[[], Numbers] | None:
        """All but random actions: the cell that does them may not have ended."""
        if manifest.status != "done":
            return None
        if self._cells:
            found = self._cells.add(manifest)
            _ = found.measured
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
            self._running[event.cell.id] = running.after(event.steps, self._now())
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
