"""Folders of recorded trainings that no experiment made, given to a command."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from harness.errors import UsageError


def holds_recordings(folders: Sequence[Path]) -> bool:
    """Whether a folder holds recorded trainings, and no experiment.

    Raises:
        UsageError: So does one of several.
    """
    from harness.record.plan_file import PLAN
    from harness.results.recordings.read_runs import has_recordings

    found = [folder for folder in folders if not (folder / PLAN).exists() and has_recordings(folder)]
    if found and len(folders) > 1:
        raise UsageError(f"'{found[0]}' holds recorded trainings: name one folder that all of them lie in")
    return bool(found)


def refuse_flags(flags: Mapping[str, object], noun: str = "a folder of recorded trainings") -> None:
    """Say which flag cannot be used.

    Raises:
        UsageError: One was given.
    """
    for flag, given in flags.items():
        if given:
            raise UsageError(f"{flag} does not go with {noun}: leave it out")
