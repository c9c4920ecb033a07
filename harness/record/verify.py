"""What in an experiment's folder is not what was written there, and how to mend it."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from harness.errors import NewerFormat, SchemaError
from harness.files.keyed_file import is_whole
from harness.files.sums import SUMS, changed_since_made
from harness.files.whole_file import is_partial
from harness.record import file_forms as forms
from harness.record.cell_folder import REMEDY, examine, require_files
from harness.record.folder import DERIVED, TRANSFER
from harness.record.manifest import Ending, Manifest, read_manifest, read_record
from harness.record.plan_file import EXPERIMENT, PLAN, is_experiment_of_plan, read_plan
from harness.record.store import CELLS, Store

DERIVED_BYTES = 2**32
DAMAGED = "damaged"
"""Where `repair` puts what is damaged: nothing is thrown away."""
PLAN_REMEDY = "harness repair puts it together from the cells; the same harness run asks for the rest"
MADE_REMEDY = "harness report or harness score makes it again"


class Problem(NamedTuple):
    """Something in a folder that is not what was written."""

    path: Path
    """In the folder; relative to it."""
    what: str
    remedy: str

    def to_json(self) -> dict[str, str]:
        """Plain data."""
        return {"path": self.path.as_posix(), "problem": self.what, "remedy": self.remedy}


class Action(NamedTuple):
    """Something that `repair` did."""

    path: Path
    what: str


def verify(folder: Path) -> list[Problem]:
    """Everything in an experiment's folder that is not what was written. Reads every file, writes none.

    Raises:
        UsageError: The folder is no experiment's.
        NewerFormat: A newer version wrote a file.
    """
    Store.open(folder)
    return [*_links(folder), *_of_plan(folder), *_of_cells(folder), *_of_transfers(folder), *_of_made(folder)]


def repair(folder: Path) -> list[Action]:
    """Make a folder such that `verify` finds nothing, and that another run does again what is missing then.

    Damaged cells go to the folder ``damaged``, links and damaged files that can be made again are removed.

    Raises:
        UsageError: The folder is no experiment's, or another run is using it.
        SchemaError: The plan is damaged, and the cells do not tell what it was.
    """
    store, done = Store.open(folder), []
    for problem in _links(folder):  # before the lock, which may be a link itself
        (folder / problem.path).unlink()
        done.append(Action(problem.path, "removed: it was a link"))
    with store.locked():
        done += _mend_plan(folder, store)
        for problem in [*_of_cells(folder), *_of_transfers(folder)]:
            done.append(_set_aside(folder, problem))
        for problem in _of_made(folder):
            (folder / problem.path).unlink(missing_ok=True)
            done.append(Action(problem.path, f"removed: {MADE_REMEDY}"))
            (folder / problem.path).with_name(SUMS).unlink(missing_ok=True)
    return done


def _links(folder: Path) -> Iterator[Problem]:
    for path in sorted(folder.rglob("*")):
        if path.is_symlink():
            yield Problem(path.relative_to(folder), "it is a link, and leads anywhere", "remove it")


def _of_plan(folder: Path) -> Iterator[Problem]:
    try:
        read_plan(folder)
    except NewerFormat:
        raise
    except SchemaError as error:
        yield Problem(Path(PLAN), str(error), PLAN_REMEDY)
        return
    if not is_experiment_of_plan(folder):
        yield Problem(Path(EXPERIMENT), f"it is not what was written beside {PLAN}", "harness repair writes it again")


def _of_cells(folder: Path) -> Iterator[Problem]:
    for path in _folders(folder / CELLS, "[!.]*"):
        inside = path.relative_to(folder)
        try:
            manifest = read_manifest(path)
        except NewerFormat:
            raise
        except SchemaError as error:
            yield Problem(inside, str(error), REMEDY)
            continue
        if manifest.cell.id != path.name:
            yield Problem(inside, f"it holds another cell, {manifest.cell.id}", REMEDY)
            continue
        found = examine(path, manifest.cell)
        if found.status == DAMAGED:
            yield Problem(inside, found.reason.removesuffix(f"; {REMEDY}"), REMEDY)


def _of_transfers(folder: Path) -> Iterator[Problem]:
    for path in _folders(folder / TRANSFER, "*/[!.]*"):
        try:
            require_files(path, read_transfer_ending(path))
        except NewerFormat:
            raise
        except SchemaError as error:
            yield Problem(path.relative_to(folder), str(error), "harness transfer does it again")


def read_transfer_ending(folder: Path) -> Ending:
    """How an evaluation in another simulator ended, and the digests of its files.

    Raises:
        SchemaError: Its manifest is damaged or written by a newer version.
    """

    def read(data: dict[str, Any]) -> Ending:
        return Ending(status=data["status"], files=data.get("files", {}))

    return read_record(folder, Manifest.FORMAT, "record of a transfer", forms.TRANSFER, read)


def _of_made(folder: Path) -> Iterator[Problem]:
    for parent in (folder, *_folders(folder / CELLS, "[!.]*")):
        for name in changed_since_made(parent):
            yield Problem((parent / name).relative_to(folder), f"it is not what {SUMS} beside it says", MADE_REMEDY)
    for path in sorted((folder / DERIVED).rglob("*")):
        if not (path.is_dir() or is_partial(path)) and not is_whole(path, DERIVED_BYTES):
            yield Problem(path.relative_to(folder), "it is not what was made", MADE_REMEDY)


def _folders(folder: Path, pattern: str) -> list[Path]:
    return sorted(path for path in folder.glob(pattern) if path.is_dir() and not path.is_symlink())


def _mend_plan(folder: Path, store: Store) -> list[Action]:
    problems = list(_of_plan(folder))
    if not problems:
        return []
    plan = store.read_plan()
    plan.write(folder)
    told = f"put together from {len(plan.cells)} cells" if plan.note else "written again"
    return [Action(problem.path, told) for problem in problems]


def _set_aside(folder: Path, problem: Problem) -> Action:
    """Move a folder to where damaged ones are kept, under a name that is free."""
    number = 0
    while (target := folder / DAMAGED / f"{problem.path.name}-{number}").exists():
        number += 1
    target.parent.mkdir(exist_ok=True)
    shutil.move(folder / problem.path, target)
    return Action(problem.path, f"moved to {target.relative_to(folder)}; {problem.remedy}")
