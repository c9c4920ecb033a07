"""How far an experiment has come, as another process sees it: ``harness status``."""

import time
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

from harness.files.plain import tells, to_plain
from harness.record.cell import Cell, Manifest, Running, read_manifest, read_running
from harness.record.pace import Begun, time_left
from harness.record.plan_file import StoredPlan, read_plan
from harness.record.store import Store


@tells("id=cell.id", "title=cell.title", "status", "reason", "steps", "of_steps=cell.steps")
@dataclass(frozen=True)
class Progress:
    """The progress of one cell.

    Attributes:
        cell: Which.
        status: ``done``, ``failed``, ``skipped``, ``damaged``, ``running``, ``interrupted`` (a run was killed while it
            did it), ``pending`` or, of an experiment that ends with its answer, ``not needed``.
        reason: Why it is not done; empty of one that is running or interrupted.
        running: How far it is, of one that is running, or was when its run was killed.
        took: Its manifest, which tells what it took, of one that is done.
    """

    cell: Cell
    status: str
    reason: str = ""
    running: Running | None = None
    took: Manifest | None = None

    @property
    def steps(self) -> int:
        """Environment steps done."""
        return self.running.steps if self.running else self.cell.steps if self.status == "done" else 0


@dataclass(frozen=True)
class FolderStatus:
    """The status of an experiment's folder.

    Attributes:
        folder: The folder.
        is_in_use: Whether a run is using it now.
        cells: Every cell of the plan, in its order.
        now: When this was so, seconds since 1970.
        note: Of the plan.
    """

    folder: Path
    is_in_use: bool
    cells: Sequence[Progress]
    now: float
    note: str = ""

    def without(self, spared: Container[Cell]) -> Self:
        """The same, where some pending cells are not needed any more."""
        cells = [replace(one, status="not needed") if one.cell in spared else one for one in self.cells]
        return replace(self, cells=cells)

    def count(self, status: str) -> int:
        """Cells of this status."""
        return sum(one.status == status for one in self.cells)

    @property
    def seconds_left(self) -> float | None:
        """What the rest will take; None if nothing is running, or no step was measured. See `time_left`."""
        running = [
            _begun(one.cell, one.running, self.now) for one in self.cells if one.running and one.status == "running"
        ]
        if not running:
            return None
        ended = [one.took for one in self.cells if one.took is not None]
        waiting = [one.cell for one in self.cells if one.status == "pending"]
        return time_left(ended, running, waiting, len(running))

    def to_json(self, recorded: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
        """Plain data; with what is recorded of trainings that go on, by the ids of their cells."""
        return {
            "format": 1,
            "folder": str(self.folder),
            "is_in_use": self.is_in_use,
            "seconds_left": self.seconds_left,
            "recovered": self.note,
            "cells": [{**to_plain(one), **recorded.get(one.cell.id, {})} for one in self.cells],
        }


def read_status(
    folder: Path,
    now: Callable[[], float] = time.time,
    plan_in: Callable[[Path], StoredPlan] = read_plan,
    manifest_in: Callable[[Path], Manifest] = read_manifest,
) -> FolderStatus:
    """How far the experiment in a folder has come. Changes nothing, and waits for nobody.

    Files are not compared with what was written, which `harness.experiment.verify` does: that would take long.

    Args:
        folder: The experiment's.
        now: The time.
        plan_in: Reads its plan; who looks often need not read it each time.
        manifest_in: The same of the manifest in a cell's folder.

    Raises:
        UsageError: The folder is no experiment's.
        SchemaError: Its plan cannot be read, and the cells do not tell it.
    """
    store = Store.open(folder)
    is_in_use, running, plan = store.is_in_use(), read_running(folder), store.read_plan(plan_in)
    cells = [_progress(cell, store, is_in_use, running.get(cell.id), manifest_in) for cell in plan.cells]
    return FolderStatus(folder, is_in_use, cells, now(), plan.note)


def _progress(
    cell: Cell, store: Store, is_in_use: bool, running: Running | None, manifest_in: Callable[[Path], Manifest]
) -> Progress:
    if running is not None:
        return Progress(cell, "running" if is_in_use else "interrupted", running=running)
    found = store.examine(cell, manifest_in)
    return Progress(cell, found.status, found.reason, took=found if found.status == "done" else None)


def _begun(cell: Cell, running: Running, now: float) -> Begun:
    if not running.steps:
        return Begun(cell, 0, None)
    since = now - running.told if running.steps >= cell.steps else 0.0
    return Begun(cell, min(running.steps, cell.steps), (running.told - running.started) / running.steps, since)
