"""The cells of several experiments' folders, made on several machines, in one folder."""

import os
import shutil
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path

from harness.errors import NewerFormat, SchemaError, UsageError
from harness.files.bounded import files_in, is_partial
from harness.record.added import Owner, owners
from harness.record.cell import Cell
from harness.record.file_forms import Status
from harness.record.folder import (
    DERIVED,
    EVALUATION_RECORDING,
    TRACE,
    TRAINING_RECORDING,
    partial_folder,
    publish,
    recording_of,
)
from harness.record.manifest import Manifest, require_files
from harness.record.out_folder import refuse_links, storage_errors
from harness.record.plan_file import StoredPlan, unite
from harness.record.recording.recorded_training import STEPS
from harness.record.store import Store

RANKS: tuple[Status, ...] = ("done", "failed", "skipped")
"""The states of a cell that is in several folders: the one with the first of these is taken."""


@dataclass(frozen=True)
class Merged:
    """What there is to write into the folder.

    Attributes:
        plan: Of all experiments.
        taken: Folders to be copied, by their place in the new one.
        left_out: Damaged folders of cells, or that a command added, which were not taken; each with what is wrong.
    """

    plan: StoredPlan
    taken: dict[Path, Path] = field(default_factory=dict)
    left_out: list[tuple[Path, str]] = field(default_factory=list)


def merge(folders: Sequence[Path], out: Path, is_temporary: bool = False) -> Merged:
    """Put the cells of experiments into one folder, whole, with what commands of plugins added to them.

    A cell that is in several folders is taken from the first where it is done, else from the first where it failed.
    What is damaged is left out. What is kept of a cell's results comes with it: a report need not compute it again.
    Tables and pages are not copied.

    Args:
        folders: Of the experiments. They are not changed.
        out: A new or empty folder, or an experiment's, which then keeps what it has.
        is_temporary: The folder is read and then removed: its files are those of the experiments under another name,
            where the system allows that, and nothing waits for the disk.

    Raises:
        UsageError: A folder is no experiment's or holds a link, the experiments have several baselines, a cell is done
            in two folders and the two differ, or `out` cannot be used. Nothing is written.
        SchemaError: A plan is damaged and the cells do not tell either, or a newer version wrote a file.
        StorageError: `out` cannot be written.
    """
    for folder in folders:
        Store.open(folder)
        refuse_links(folder, "nothing is merged from a folder with links")
    with storage_errors(out), ExitStack() as held:
        is_begun = Store.is_experiment(out)
        if is_begun:
            held.enter_context(Store.claim(out).locked())
        merged = _choose([*([out] if is_begun else []), *folders])
        if not is_begun:
            held.enter_context(Store.claim(out).locked())
        merged.plan.write(out)
        for place, source in merged.taken.items():
            if source != out / place:
                _copy(source, out / place, is_temporary, is_lasting=not is_temporary and place.parts[0] != DERIVED)
    return merged


def _choose(folders: Sequence[Path]) -> Merged:
    stores = [Store(folder) for folder in dict.fromkeys(folders)]
    merged, added = Merged(unite([(store.folder, store.read_plan()) for store in stores])), owners()
    for cell in merged.plan.cells:
        chosen = _choose_cell(cell, stores, merged.left_out)
        if chosen is not None:
            for source in (chosen.cell_folder(cell), chosen.folder / DERIVED / cell.id):
                if source.is_dir():
                    merged.taken[source.relative_to(chosen.folder)] = source
            _choose_added(cell, [chosen, *(store for store in stores if store is not chosen)], added, merged)
    return merged


def _choose_cell(cell: Cell, stores: Iterable[Store], left_out: list[tuple[Path, str]]) -> Store | None:
    """The store whose cell is taken; None if the cell has not ended anywhere."""
    found = [(store, store.examine(cell)) for store in stores]
    left_out += [(store.cell_folder(cell), it.reason) for store, it in found if it.status == "damaged"]
    done = [(store.folder, _digests_of_steps(it)) for store, it in found if it.status == "done"]
    for folder, digests in done:
        if digests != done[0][1]:
            raise UsageError(
                f"Cell {cell.id} ({cell.title}) was trained in '{done[0][0]}' and in '{folder}', and the steps differ: "
                "remove it from one of them, in the folder cells/, and merge again"
            )
    return next((store for status in RANKS for store, it in found if it.status == status), None)


def _digests_of_steps(manifest: Manifest) -> dict[str, str]:
    """SHA-256 of the files that hold a cell's steps: all parts of the trace, or in an environment of both recordings.

    The facts beside the steps of a recording do not count: they name versions, which may differ between machines.
    """
    recorded = (
        recording_of(TRACE),
        *(f"{recording}/{STEPS}" for recording in (TRAINING_RECORDING, EVALUATION_RECORDING)),
    )
    return {name: digest for name, digest in manifest.files.items() if name.startswith(recorded)}


def _choose_added(cell: Cell, stores: Iterable[Store], added: Mapping[str, Owner], merged: Merged) -> None:
    """Take, of folders with the same name that commands added, the first that is done, else the first that failed."""
    ranks: dict[Path, int] = {}
    for store, (name, owner) in product(stores, added.items()):
        for folder in sorted((store.folder / name / cell.id).glob("[!.]*")):
            try:
                ending = owner.ending(folder)
                require_files(folder, ending)
            except NewerFormat:
                raise
            except SchemaError as error:
                merged.left_out.append((folder, str(error)))
                continue
            place, rank = folder.relative_to(store.folder), (*RANKS, ending.status).index(ending.status)
            if rank < ranks.get(place, len(RANKS)):
                ranks[place], merged.taken[place] = rank, folder


def _copy(source: Path, target: Path, may_share: bool, *, is_lasting: bool) -> None:
    """Copy the folder of a cell, of its kept results or one that was added; it is there when it is whole."""
    partial = partial_folder(target)
    if partial.exists():
        shutil.rmtree(partial)
    partial.mkdir(parents=True)
    for path in files_in(source):
        copy = partial / path.relative_to(source)
        if path.is_symlink() or is_partial(path):
            continue
        copy.parent.mkdir(parents=True, exist_ok=True)
        with suppress(OSError):  # of another file system, or one without such names
            if may_share:
                os.link(path, copy)
        if not copy.exists():
            shutil.copyfile(path, copy)
    publish(partial, target, is_lasting=is_lasting)
