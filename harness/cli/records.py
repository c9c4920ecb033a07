"""Records of an experiment, small enough to be kept beside the code: a plugin writes and reads them."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from rich.console import RenderableType

    from harness.results import Results

OPTION = "report--summary"
"""The name, among commands, of the plugin that writes what ``harness report --summary`` asks for."""


class Records(NamedTuple):
    """What that plugin brings."""

    write: "Callable[[Results, Path], None]"
    """Writes the records of an experiment into a folder; raises UsageError if that cannot be."""
    are_in: Callable[[Path], bool]
    """Whether a folder holds records, and no experiment."""
    text: Callable[[Path], str]
    """The records in a folder as JSON."""
    table: "Callable[[Path], RenderableType]"
    """The records in a folder as a terminal shows them."""
    refuse: Callable[[Path, str], None]
    """Raises UsageError for a folder of records: a flag, or a command, needs cells."""


def load_records() -> Records:
    """The plugin that writes records; raises UsageError if it was left out."""
    from harness.registry.registry import load_registry

    records: Records = load_registry().get("commands", OPTION).load()()
    return records


def records_in(folders: Sequence[Path]) -> Records | None:
    """What reads them if one of the folders holds records; None if none does."""
    from harness.errors import UsageError
    from harness.record.plan_file import PLAN

    if all((folder / PLAN).exists() for folder in folders):
        return None
    try:
        records = load_records()
    except UsageError:
        return None
    return records if any(map(records.are_in, folders)) else None
