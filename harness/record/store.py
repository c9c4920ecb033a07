"""An experiment's folder. The folder is the database: what is done is what it says is done.

::

    experiment.toml                the newest experiment, resolved; reads as an experiment file
    plan.json                      the cells of all experiments that were run here, and the baseline
    cells/<id>/                    one folder per cell, there only when the cell has ended
        manifest.json trace.parquet evaluation.parquet policy/ log.txt
        random.parquet                 in one cell of each simulator, task and robot
        stochastic.parquet or deterministic.parquet: the other manner than that of evaluation.parquet
        evaluations/<steps>.parquet               where they were asked for
    NAME/<id>/<...>/               what commands of plugins add; see `harness.record.added`
    results.parquet report.html    made from the cells
"""

import shutil
from collections.abc import Callable, Container, Hashable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.errors import NewerFormat, SchemaError, UsageError
from harness.files.bounded import is_partial
from harness.record.cell import REMEDY, Cell, Manifest, is_named, now, read_manifest, whole_cell
from harness.record.file_forms import Status
from harness.record.folder import CHECKPOINT, LOG, MANIFEST, RANDOM, RANDOM_RECORDING, partial_folder, publish
from harness.record.out_folder import folder_lock, is_held, make_folder, refuse_links, require_text
from harness.record.plan_file import EXPERIMENT, PLAN, StoredPlan, plan_from_cells, read_plan
from harness.record.terms import Terms
from harness.registry.spec import nothing_at

if TYPE_CHECKING:
    from harness.experiment.plan import Plan

CELLS, RESULTS, REPORT, LOCK = "cells", "results.parquet", "report.html", ".lock"
FLOORS = (RANDOM, RANDOM_RECORDING)
"""Where a cell, of an arm or in an environment, leaves what random actions did."""
MOST_NAMED = 5
"""Most experiments that a message about the folder above them names."""


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
        require_text(folder, "Folder")
        if not folder.is_dir():
            raise UsageError(f"{nothing_at(folder, 'folder')} Name the --out folder of a run")
        if not cls.is_experiment(folder):
            inside = sorted(path.parent.name for path in folder.glob(f"*/{PLAN}"))
            told = f". Experiments in it: {', '.join(inside[:MOST_NAMED])}" if inside else ""
            raise UsageError(f"'{folder}' is no experiment: it holds no {PLAN}. Name the --out folder of a run{told}")
        return cls(folder)

    @classmethod
    def is_experiment(cls, folder: Path) -> bool:
        """Whether a folder holds an experiment, of which the plan may be lost."""
        return (folder / PLAN).is_file() or bool(cls(folder)._left_manifests())

    @classmethod
    def at(cls, folder: Path) -> "Store":
        """A folder for an experiment, new or to go on with. Nothing is written.

        Raises:
            UsageError: It holds something else, or a link.
        """
        require_text(folder)
        if folder.exists() and not folder.is_dir():
            raise UsageError(f"--out '{folder}' is a file: name a folder")
        if folder.is_dir() and not _is_usable(folder):
            raise UsageError(f"--out '{folder}' holds something else than an experiment: name a new or empty folder")
        refuse_links(folder)
        return cls(folder)

    @classmethod
    def claim(cls, folder: Path) -> "Store":
        """The same, and the folder is made if it is not there.

        Raises:
            UsageError: As `at`, or the folder cannot be written.
        """
        store = cls.at(folder)
        make_folder(folder, CELLS)
        return store

    def add(self, plan: "Plan") -> None:
        """Write down what is asked for, beside all that was before; skipped cells leave their reason."""
        known = self.known()
        cells = dict.fromkeys([*plan.cells, *(cell for cell, _ in plan.skipped)])
        asked = StoredPlan(
            plan.baseline,
            bool(plan.control),
            plan.control,
            tuple(cells),
            _without_none(plan.resolved),
            "" if cells.keys() >= set(known.cells) else known.note,
            self._terms(plan.terms, known, tuple(cells)),
        )
        asked.with_cells_of(known.cells).write(self.folder)
        for cell, reason in plan.skipped:
            self.record(cell, "skipped", reason)

    def read_plan(self, read: Callable[[Path], StoredPlan] = read_plan) -> StoredPlan:
        """What was asked for; where ``plan.json`` is damaged, as far as the cells tell.

        Args:
            read: Gives the plan in a folder.

        Raises:
            NewerFormat: A newer version wrote it.
            SchemaError: The cells do not tell either.
        """
        try:
            return read(self.folder)
        except NewerFormat:
            raise
        except SchemaError as error:
            return plan_from_cells(self.folder, self._ended_cells(), str(error))

    @contextmanager
    def locked(self, on_wait: Callable[[], None] | None = None) -> Iterator[None]:
        """Keep other runs out of the folder.

        Args:
            on_wait: Wait for another run to end; this is called first. None: do not wait.

        Raises:
            UsageError: Another run is using it, or a link leads out of it.
        """
        refuse_links(self.folder)
        with folder_lock(self.folder / LOCK, f"Another run is using '{self.folder}'", on_wait):
            yield

    def is_in_use(self) -> bool:
        """Whether a run is using the folder."""
        return is_held(self.folder / LOCK)

    def cell_folder(self, cell: Cell) -> Path:
        """Where the cell's results are, once it has ended."""
        return self.folder / CELLS / cell.id

    def log_of(self, cell: Cell) -> Path:
        """Where what the cell printed is, once it has ended."""
        return self.cell_folder(cell) / LOG

    def examine(self, cell: Cell, read: Callable[[Path], Manifest] = whole_cell) -> Manifest:
        """What there is to say of a cell: its manifest, if every file is what the cell left; else damaged, or pending.

        Args:
            cell: The cell.
            read: Gives the manifest of a folder; `read_manifest` where its other files are not looked at.

        Raises:
            NewerFormat: A newer version made the cell.
        """
        folder = self.cell_folder(cell)
        if not folder.is_symlink() and not folder.exists():
            return Manifest(cell, status="pending", reason="not run yet")
        try:
            return read(folder)
        except NewerFormat:
            raise
        except SchemaError as error:
            return Manifest(cell, status="damaged", reason=f"{error}; {REMEDY}")

    def record(self, cell: Cell, status: Status, reason: str, instead_of: Manifest | None = None) -> Manifest:
        """Leave a manifest for a cell that could not leave one itself; keeps its log.

        A done cell is left as it is, unless what it says of itself is `instead_of`: that was to be done again.
        """
        folder = self.cell_folder(cell)
        found = self.examine(cell)
        if found.status == "done" and found != instead_of:
            return found
        partial = partial_folder(folder)
        partial.mkdir(parents=True, exist_ok=True)
        manifest = Manifest(cell, status=status, reason=reason, started=now()).write(partial)
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
        """The manifests of all cells that have ended, by start; those that cannot be read are left out.

        Raises:
            NewerFormat: A newer version wrote one.
        """
        found = []
        for path in self._left_manifests():
            try:
                found.append(read_manifest(path.parent))
            except NewerFormat:
                raise
            except SchemaError:
                continue  # `examine` says what is wrong with it
        return sorted(found, key=lambda manifest: (manifest.started, manifest.cell.id))

    def _left_manifests(self) -> list[Path]:
        return sorted((self.folder / CELLS).glob(f"[!.]*/{MANIFEST}"))

    def _terms(self, asked: Terms, before: StoredPlan, cells: Sequence[Cell]) -> Terms:
        """Those of the first experiment in the folder.

        They say where seeds and rewards were added after results could be seen.
        """
        known, terms = before.cells, before.terms
        if not known:
            return asked
        done = {cell.seed for cell in self._ended_cells()}
        if not done or terms.has_plan:
            return replace(terms, seconds=asked.seconds)
        kinds = {replace(cell, seed=0) for cell in known}
        added = {cell.seed for cell in cells if replace(cell, seed=0) in kinds} - {cell.seed for cell in known}
        rewards = {cell.reward.label for cell in known}
        joined = dict.fromkeys(cell.reward.label for cell in cells if cell.reward.label not in rewards)
        grown = (*terms.grown, len(done)) if added else terms.grown
        return replace(terms, grown=grown, joined=(*terms.joined, *joined))

    def known(self) -> StoredPlan:
        """What was asked for before; where the plan is damaged, what has ended: the rest is asked for again."""
        note = ""
        try:
            if self.is_experiment(self.folder):
                return self.read_plan()
        except NewerFormat:
            raise
        except SchemaError as error:
            note = str(error)
        return StoredPlan("", False, {}, tuple(self._ended_cells()), note=note)

    def _ended_cells(self) -> list[Cell]:
        return [manifest.cell for manifest in self.manifests()]


def _is_usable(folder: Path) -> bool:
    """Whether it holds an experiment, or nothing but what a run leaves that is killed before its plan is written."""
    if Store.is_experiment(folder):
        return True
    left = {path.name for path in folder.iterdir() if not is_partial(path)}
    cells = folder / CELLS
    return not left or (left <= {CELLS, LOCK, EXPERIMENT} and cells.is_dir() and not any(cells.iterdir()))


def _without_none(value: Any) -> Any:
    """TOML has no null: a parameter that is None is left out, and its default is None again."""
    if isinstance(value, dict):
        return {key: _without_none(item) for key, item in value.items() if item is not None}
    return [_without_none(item) for item in value] if isinstance(value, list) else value


def floors_in(manifests: Iterable[Manifest], store: Store) -> dict[Hashable, Cell]:
    """The floors that are there, each with the first done cell that evaluated it; cells of version 0.1 all did.

    Args:
        manifests: Of cells of the experiment; those that are not done are left out.
        store: Its folder.
    """
    found: dict[Hashable, Cell] = {}
    for manifest in (it for it in manifests if it.status == "done"):
        folder = store.cell_folder(manifest.cell)
        if any((folder / name).exists() and is_named(manifest, name) for name in FLOORS):
            found.setdefault(manifest.cell.floor, manifest.cell)
    return found
