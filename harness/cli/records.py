"""Records of an experiment, small enough to be kept beside the code: a plugin writes and reads them."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from rich.console import RenderableType

    from harness.results import Results

OPTION = "report--summary"
"""The name, among commands, of the plugin that writes what ``harness report --summary`` asks for."""


class Records(Protocol):
    """What that plugin brings."""

    def write(self, results: "Results", folder: Path) -> None:
        """Write the records of an experiment into `folder`; raises UsageError if that cannot be."""

    def are_in(self, folder: Path) -> bool:
        """Whether a folder holds records, and no experiment."""

    def text(self, folder: Path) -> str:
        """The records as JSON."""

    def table(self, folder: Path) -> "RenderableType":
        """The records as a terminal shows them."""

    def refuse(self, folder: Path, flag: str) -> None:
        """Raise UsageError: the flag needs cells, which records have not."""


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
