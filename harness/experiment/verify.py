"""What in an experiment's folder is not what was written there, and how to mend it."""

import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from harness.errors import NewerFormat, SchemaError, UsageError
from harness.files.bounded import (
    SUMS,
    changed_since_made,
    files_in,
    forget_made,
    is_partial,
    is_whole,
    read_sums,
    write_whole,
)
from harness.policy import load_policy
from harness.record.added import owners
from harness.record.cell import REMEDY, added_files, read_manifest, require_files, whole_cell
from harness.record.folder import CARD, DERIVED, POLICY, SCORES
from harness.record.plan_file import EXPERIMENT, PLAN, experiment_in, read_plan
from harness.record.store import CELLS, REPORT, RESULTS, Store

DERIVED_BYTES = 2**32
DAMAGED = "damaged"
"""Where `repair` puts what is damaged: nothing is thrown away."""
ADDED_REMEDY = "harness verify --repair sets it aside"
PLAN_REMEDY = "harness verify --repair puts it together from the cells; the same harness run asks for the rest"
MADE_REMEDY = "harness report or harness score makes it again"
LINE_REMEDY = f"nothing moves what has this name: take the line out of {SUMS}"
FOREIGN_REMEDY = "no report reads it and nothing moves it: take it away if it is not yours"
_CELL, _ADDED = re.compile(r"[0-9a-f]{16}"), re.compile(r".+-[0-9a-f]{12}")
"""Names of folders; see `harness.record.cell.Cell.id` and `harness.record.added`."""
LONGEST_NAME = 200
"""Bytes of a name that are kept among what is damaged, where a number follows."""


class Problem(NamedTuple):
    """Something in a folder that is not what was written."""

    path: Path
    """In the folder; relative to it."""
    what: str
    remedy: str
    stays: bool = False
    """Whether `repair` tells it and leaves it: the harness makes nothing of this name in this place."""

    def to_json(self) -> dict[str, str]:
        """Plain data."""
        return {"path": self.path.as_posix(), "problem": self.what, "remedy": self.remedy}


def verify(folder: Path) -> list[Problem]:
    """Everything in an experiment's folder that is not what was written. Reads every file, writes none.

    Raises:
        UsageError: The folder is no experiment's.
        NewerFormat: A newer version wrote a file.
    """
    Store.open(folder)
    return [*_links(folder), *_of_plan(folder), *_of_cells(folder), *_of_added(folder), *_of_made(folder)]


def missing_cells(folder: Path) -> tuple[int, int, str]:
    """How many cells of the plan have left nothing, how many cells the plan has, and its note.

    They are not run yet, or somebody took them away: nothing in the folder tells which.
    """
    store = Store.open(folder)
    plan = store.known()
    return sum(not store.cell_folder(cell).exists() for cell in plan.cells), len(plan.cells), plan.note


def repair(folder: Path) -> list[tuple[Path, str]]:
    """Make a folder such that `verify` finds nothing, and that another run does again what is missing then.

    It returns what was done, by the paths of problems.

    Nothing is thrown away: what is damaged goes to the folder ``damaged``, of a link a text that says where it led.
    Whoever made the folder wrote its names too. So only what the harness itself makes is moved, in its place: folders
    of cells and those that commands add, and regular files. All else is told and left.

    Raises:
        UsageError: The folder is no experiment's, another run is using it, or ``damaged`` is no folder.
        SchemaError: The plan is damaged, and the cells do not tell what it was.
    """
    store = Store.open(folder)
    # Before the lock, which may be a link itself; the folder for what is damaged first.
    links = sorted(_links(folder), key=lambda problem: problem.path != Path(DAMAGED))
    done = [_note_link(folder, problem) for problem in links]
    with store.locked():
        done += _mend_plan(folder, store)
        for find in (_of_cells, _of_added, _of_made):
            done += [_set_aside(folder, problem) for problem in [*find(folder)]]
    return done


def _links(folder: Path) -> Iterator[Problem]:
    for path in sorted(folder.rglob("*")):
        if path.is_symlink():
            yield Problem(
                path.relative_to(folder),
                "it is a link, and leads anywhere",
                "harness verify --repair removes it, and notes where it led",
            )


def _of_plan(folder: Path) -> Iterator[Problem]:
    try:
        plan = read_plan(folder)
    except NewerFormat:
        raise
    except SchemaError as error:
        yield Problem(Path(PLAN), str(error), PLAN_REMEDY)
        return
    if experiment_in(folder) != plan.experiment:
        yield Problem(
            Path(EXPERIMENT), f"it is not what was written beside {PLAN}", "harness verify --repair writes it again"
        )


def _of_cells(folder: Path) -> Iterator[Problem]:
    for path in _folders(folder / CELLS, "[!.]*"):
        inside = path.relative_to(folder)
        if not _CELL.fullmatch(path.name):
            yield Problem(inside, "it has no name that a cell has", FOREIGN_REMEDY, stays=True)
            continue
        try:
            manifest = whole_cell(path)
            if manifest.status == "done" and (path / POLICY / CARD).exists():
                load_policy(path / POLICY)
        except NewerFormat:
            raise
        except SchemaError as error:
            yield Problem(inside, str(error), REMEDY)
            continue
        for name in added_files(path, manifest):
            stays = not _is_regular(path / name)
            remedy = FOREIGN_REMEDY if stays else ADDED_REMEDY
            yield Problem(inside / name, "the cell did not leave it, and no report reads it", remedy, stays)


def _of_added(folder: Path) -> Iterator[Problem]:
    """Folders that commands of plugins added."""
    for name, owner, path in ((*it, path) for it in owners().items() for path in _folders(folder / it[0], "*/[!.]*")):
        inside = path.relative_to(folder)
        if not (_CELL.fullmatch(path.parent.name) and _ADDED.fullmatch(path.name)):
            yield Problem(inside, f"it has no name that {owner.what} has", FOREIGN_REMEDY, stays=True)
            continue
        try:
            require_files(path, owner.ending(path))
        except NewerFormat:
            raise
        except SchemaError as error:
            yield Problem(inside, str(error), f"harness {name} does it again")


def _of_made(folder: Path) -> Iterator[Problem]:
    for parent in (folder, *_folders(folder / CELLS, "[!.]*")):
        made = _made_in(parent, folder)
        for name in sorted(changed_since_made(parent)):
            path = parent / name
            if name in made and (_is_regular(path) or not os.path.lexists(path)):
                yield Problem(path.relative_to(folder), f"it is not what {SUMS} beside it says", MADE_REMEDY)
            else:
                what = f"it says otherwise of '{name}', which is no file that the harness makes there"
                yield Problem((parent / SUMS).relative_to(folder), what, LINE_REMEDY, stays=True)
    for path in files_in(folder / DERIVED):
        if _is_regular(path) and not is_partial(path) and not is_whole(path, DERIVED_BYTES):
            yield Problem(path.relative_to(folder), "it is not what was made", MADE_REMEDY)


def _made_in(parent: Path, folder: Path) -> set[str]:
    """Files that commands of the harness make in this place, whatever a list of digests says of others."""
    if parent == folder:
        return {RESULTS, REPORT, SUMS}
    try:
        return {SCORES, SUMS} - read_manifest(parent).files.keys()
    except SchemaError:
        return {SCORES, SUMS}


def _is_regular(path: Path) -> bool:
    return path.is_file() and not path.is_symlink()


def _folders(folder: Path, pattern: str) -> list[Path]:
    return sorted(path for path in folder.glob(pattern) if path.is_dir() and not path.is_symlink())


def _mend_plan(folder: Path, store: Store) -> list[tuple[Path, str]]:
    problems = list(_of_plan(folder))
    if not problems:
        return []
    plan = store.read_plan()
    for name in (PLAN, EXPERIMENT):
        if (folder / name).is_file():
            shutil.copyfile(folder / name, _free_name(folder, name))
    plan.write(folder)
    told = {Path(PLAN): f"put together from {len(plan.cells)} cells"}
    return [(problem.path, told.get(problem.path, "written again")) for problem in problems]


def _set_aside(folder: Path, problem: Problem) -> tuple[Path, str]:
    """Move a folder or a file to where damaged ones are kept; a list that tells of it is written anew."""
    if problem.stays:
        return (problem.path, f"{problem.what}. It stays: {problem.remedy}")
    path, told = folder / problem.path, f"it is gone; {MADE_REMEDY}"  # the list told of it
    if os.path.lexists(path):
        target = _free_name(folder, path.name)
        try:
            os.rename(path, target)  # what lies on another disk is not copied and removed
            told = f"moved to {target.relative_to(folder)}; {problem.remedy}"
        except OSError as error:
            told = f"it cannot be moved, {error.strerror}; it stays"
    if path.name in read_sums(path.parent):
        forget_made(path)
    return (problem.path, told)


def _note_link(folder: Path, problem: Problem) -> tuple[Path, str]:
    """Put a text in place of a link, among what is damaged: it says where the link led."""
    path = folder / problem.path
    led = os.readlink(path)
    path.unlink()
    target = _free_name(folder, path.name)
    write_whole(target, f"{led}\n".encode(errors="surrogateescape"))
    return (problem.path, f"it was a link; {target.relative_to(folder)} says where it led")


def _free_name(folder: Path, name: str) -> Path:
    """A path among what is damaged that nothing has yet."""
    home = folder / DAMAGED
    if os.path.lexists(home) and not home.is_dir():
        raise UsageError(f"'{home}' is no folder, and what is damaged goes there: rename it")
    home.mkdir(exist_ok=True)
    begin, number = os.fsdecode(os.fsencode(name)[:LONGEST_NAME]), 0
    while os.path.lexists(target := home / f"{begin}-{number}"):
        number += 1
    return target
