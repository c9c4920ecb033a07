"""The cells of several experiments' folders, made on several machines, in one folder."""

import os
import shutil
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path, PurePosixPath

from harness.errors import NewerFormat, SchemaError, UsageError
from harness.files.bounded import files_in, is_partial
from harness.record.added import Owner, owners
from harness.record.cell import Cell, Ending, is_needed, require_files
from harness.record.file_forms import Status
from harness.record.folder import (
    DERIVED,
    POLICY,
    RANDOM_RECORDING,
    partial_folder,
    publish,
)
from harness.record.out_folder import refuse_links, storage_errors
from harness.record.plan_file import StoredPlan, unite
from harness.record.recording.recorded_training import FILES
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
        UsageError: A folder is no experiment's or holds a link, the experiments have several baselines, a file of a
            cell is not the same in all folders in which it is done, or `out` cannot be used. Nothing is written.
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
        found = [(store.cell_folder(cell), store.examine(cell)) for store in stores]
        merged.left_out.extend((folder, it.reason) for folder, it in found if it.status == "damaged")
        chosen = _first(f"Cell {cell.id} ({cell.title})", found)
        if chosen is not None:
            home = chosen.parents[1]
            merged.taken.update((it.relative_to(home), it) for it in (chosen, home / DERIVED / cell.id) if it.is_dir())
            _choose_added(cell, dict.fromkeys((home, *folders)), added, merged)
    return merged


def _first(what: str, found: Sequence[tuple[Path, Ending]]) -> Path | None:
    """The folder that is taken of those that hold one thing; None if it has not ended in any.

    What is done in several folders left the same files there: else their order would decide a report. Logs and the
    facts of recordings tell times and versions. What random actions did is left by one cell of several.

    Raises:
        UsageError: A file differs.
    """
    done = [it for it in found if it[1].status == "done"]
    for folder, ending in done[1:]:
        first, whole = done[0]
        alone = whole.files.keys() ^ ending.files.keys()
        for name, _ in sorted(whole.files.items() ^ ending.files.items()):
            tells_times = PurePosixPath(name).match(FILES[0]) or not (is_needed(name) or name.startswith(POLICY))
            if not tells_times and not (name in alone and name.startswith(RANDOM_RECORDING)):
                raise UsageError(
                    f"{what} is done in '{first}' and in '{folder}', and {name} is not the same in both: take one of "
                    "the two folders away, and merge again"
                )
    return next((folder for status in RANKS for folder, it in found if it.status == status), None)


def _choose_added(cell: Cell, homes: Iterable[Path], added: Mapping[str, Owner], merged: Merged) -> None:
    """Take, of folders with the same name that commands added, the first that is done, else the first that failed."""
    found: dict[Path, list[tuple[Path, Ending]]] = {}
    for home, (name, owner) in product(homes, added.items()):
        for folder in sorted((home / name / cell.id).glob("[!.]*")):
            try:
                ending = owner.ending(folder)
                require_files(folder, ending)
            except NewerFormat:
                raise
            except SchemaError as error:
                merged.left_out.append((folder, str(error)))
                continue
            found.setdefault(folder.relative_to(home), []).append((folder, ending))
    for place, folders in found.items():
        if (chosen := _first(str(place), folders)) is not None:
            merged.taken[place] = chosen


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
