"""An experiment's folder. The folder is the database: what is done is what it says is done.

::

    experiment.toml                the newest experiment, resolved; reads as an experiment file
    plan.json                      the cells of all experiments that were run here, and the baseline
    cells/<id>/                    one folder per cell, there only when the cell has ended
        manifest.json trace.parquet evaluation.parquet random.parquet policy/ log.txt
        stochastic.parquet or deterministic.parquet: the other manner than that of evaluation.parquet
        evaluations/<steps>.parquet tensorboard/  where they were asked for
    transfer/<id>/<simulator id>/  policies evaluated in other simulators; see `harness.transfer.record`
    results.parquet report.html    made from the cells
"""

import json
import shutil
from collections.abc import Container, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import tomli_w

from harness.errors import SchemaError, UsageError
from harness.files.whole_file import is_partial, write_whole
from harness.record.cell import Cell
from harness.record.folder import CHECKPOINT, MANIFEST, partial_folder, publish
from harness.record.manifest import Manifest, Status, now, read_manifest
from harness.record.out_folder import folder_lock, make_folder

if TYPE_CHECKING:
    from harness.experiment.plan import Plan

EXPERIMENT, PLAN, CELLS, RESULTS, REPORT, LOCK = (
    "experiment.toml",
    "plan.json",
    "cells",
    "results.parquet",
    "report.html",
    ".lock",
)


class StoredPlan(NamedTuple):
    """What was asked for in an experiment's folder."""

    baseline: str
    """Label of the reward that the others are compared with."""
    a_a: bool
    """Whether the newest experiment compares the baseline with itself."""
    control: Mapping[int, int]
    """By each seed the other seed that the baseline is trained with again for that; version 0.1 had none."""
    cells: tuple[Cell, ...]
    """Of all experiments that were run here."""


class Store:
    """Reads and writes one experiment's folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @classmethod
    def open(cls, folder: Path) -> "Store":
        """An experiment that exists.

        Raises:
            UsageError: The folder is not there, or is not an experiment's.
        """
        missing = [name for name in (PLAN, EXPERIMENT) if not (folder / name).is_file()]
        if missing:
            raise UsageError(f"'{folder}' is no experiment: it holds no {missing[0]}. Name the --out folder of a run")
        return cls(folder)

    @classmethod
    def create(cls, folder: Path, plan: "Plan") -> "Store":
        """A new experiment, or one to go on with: cells that are done stay done.

        Raises:
            UsageError: The folder cannot be written, or holds something else.
        """
        if folder.exists() and not folder.is_dir():
            raise UsageError(f"--out '{folder}' is a file: name a folder")
        if folder.is_dir() and not _is_usable(folder):
            raise UsageError(f"--out '{folder}' holds something else than an experiment: name a new or empty folder")
        make_folder(folder, CELLS)
        store = cls(folder)
        with store.locked():
            store._write_plan(plan)
            for cell, reason in plan.skipped:
                store.record(cell, "skipped", reason)
        return store

    def read_plan(self) -> StoredPlan:
        """What was asked for.

        Raises:
            SchemaError: The file is damaged.
        """
        path = self.folder / PLAN
        try:
            data = json.loads(path.read_text())
            cells = tuple(Cell.from_json(cell) for cell in data["cells"])
            control = {int(seed): int(other) for seed, other in data.get("control", [])}
            return StoredPlan(data["baseline"], bool(data["a_a"]), control, cells)
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise SchemaError(f"{path} is no readable plan: {error!r}") from error

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Keep other runs out of the folder.

        Raises:
            UsageError: Another run is using it.
        """
        with folder_lock(self.folder / LOCK, f"Another run is using '{self.folder}'"):
            yield

    def cell_folder(self, cell: Cell) -> Path:
        """Where the cell's results are, once it has ended."""
        return self.folder / CELLS / cell.id

    def is_done(self, cell: Cell) -> bool:
        """Whether the cell need not be run again."""
        folder = self.cell_folder(cell)
        return (folder / MANIFEST).is_file() and read_manifest(folder).status == "done"

    def record(self, cell: Cell, status: Status, reason: str) -> Manifest:
        """Leave a manifest for a cell that could not leave one itself; keeps its log. A done cell is left as it is."""
        folder = self.cell_folder(cell)
        if self.is_done(cell):
            return read_manifest(folder)
        partial = partial_folder(folder)
        partial.mkdir(parents=True, exist_ok=True)
        manifest = Manifest(cell, status=status, reason=reason, started=now())
        manifest.write(partial)
        publish(partial, folder)
        return manifest

    def discard_partial(self, keep: Container[Path] = ()) -> None:
        """Remove what a killed run left, but for partial folders in `keep`, and those that a cell can go on from."""
        for folder in (self.folder / CELLS).glob(".*.partial"):
            if folder not in keep and not (folder / CHECKPOINT).is_file():
                shutil.rmtree(folder)

    def reopen(self, cell: Cell) -> Path:
        """The partial folder of a cell that is not done; a checkpoint of a process that was killed is in it again."""
        folder = self.cell_folder(cell)
        partial = partial_folder(folder)
        if (folder / CHECKPOINT).is_file() and not partial.exists():
            folder.rename(partial)
            (partial / MANIFEST).unlink(missing_ok=True)
        return partial

    def manifests(self) -> list[Manifest]:
        """Of all cells that have ended, by start."""
        found = [read_manifest(path.parent) for path in (self.folder / CELLS).glob(f"[!.]*/{MANIFEST}")]
        return sorted(found, key=lambda manifest: (manifest.started, manifest.cell.id))

    def _write_plan(self, plan: "Plan") -> None:
        """Add the plan's cells to those that are there: a folder grows, nothing is lost."""
        path = self.folder / PLAN
        known = self.read_plan().cells if path.exists() else ()
        cells = dict.fromkeys([*known, *plan.cells, *(cell for cell, _ in plan.skipped)])
        data = {
            "baseline": plan.baseline,
            "a_a": bool(plan.control),
            "control": [list(pair) for pair in plan.control.items()],
            "cells": [cell.to_json() for cell in cells],
        }
        write_whole(path, json.dumps(data, indent=1) + "\n")
        write_whole(self.folder / EXPERIMENT, tomli_w.dumps(_without_none(plan.resolved)))


def _is_usable(folder: Path) -> bool:
    """Whether it holds an experiment, or nothing but what a run leaves that is killed before its plan is written."""
    if (folder / PLAN).is_file():
        return True
    left = {path.name for path in folder.iterdir() if not is_partial(path)}
    cells = folder / CELLS
    return not left or (left <= {CELLS, LOCK, EXPERIMENT} and cells.is_dir() and not any(cells.iterdir()))


def _without_none(value: Any) -> Any:
    """TOML has no null: a parameter that is None is left out, and its default is None again."""
    if isinstance(value, dict):
        return {key: _without_none(item) for key, item in value.items() if item is not None}
    return [_without_none(item) for item in value] if isinstance(value, list) else value
