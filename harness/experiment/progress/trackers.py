"""Tells trackers what happens to cells. The cells go on, no matter what a tracker does."""

import queue
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

from harness.errors import PluginError, UsageError, one_line
from harness.executor import Event
from harness.record.cell import Cell
from harness.record.running import Running
from harness.registry.choice import Choice, choose, split_list
from harness.registry.registry import Registry
from harness.tracker import Outcome, Track, TrackedCell, Tracker

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
