"""Folders of recorded trainings, and of logs, that no experiment made, given to a command."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from harness.errors import UsageError

if TYPE_CHECKING:
    from harness.results.logs.told import Told


def holds_recordings(folders: Sequence[Path]) -> bool:
    """Whether a folder holds recorded trainings, and no experiment.

    Raises:
        UsageError: So does one of several.
    """
    from harness.record.plan_file import PLAN
    from harness.results.recordings.recordings import has_recordings

    found = [folder for folder in folders if not (folder / PLAN).exists() and has_recordings(folder)]
    if found:
        require_one_folder(folders, "recorded trainings")
    return bool(found)


def is_experiment(folder: Path) -> bool:
    """Whether a folder, or a file that lies in one, is an experiment's."""
    from harness.record.store import Store

    return Store.is_experiment(folder)


def require_one_folder(folders: Sequence[Path], noun: str) -> None:
    """Check that what no experiment made is named by one folder.

    Raises:
        UsageError: Several are given.
    """
    if len(folders) > 1:
        raise UsageError(f"'{folders[0]}' holds {noun}: name one folder that all of them lie in")


def told_of_logs(
    as_format: str | None,
    sort: str | None,
    baseline: str | None,
    measure: Sequence[str] | None,
    labels: Path | None,
    leave_out: Sequence[Path] | None = None,
    per_step: str | None = None,
    ends: Sequence[str] | None = None,
) -> "Told":
    """What the flags say of logs.

    Raises:
        UsageError: What decides is malformed, or stands twice.
    """
    from harness.results.logs.told import Told, parse_deciding, parse_ends

    if measure is not None and len(measure) > 1:
        raise UsageError(
            f"--measure {measure[1]}: one measure of the logs decides, and --measure {measure[0]} names it"
        )
    deciding = parse_deciding(measure[0] if measure else "")
    return Told(
        as_format or "", sort or "", baseline or "", deciding, labels, tuple(leave_out or ()), per_step or "",
        parse_ends(ends or ()),
    )  # fmt: skip
