"""Committed records, as ``harness report`` asks for them."""

from pathlib import Path

from rich.console import RenderableType

from harness.results import Results

from .read import committed_table, committed_text, is_committed, refuse_committed
from .summary import write_summary


class Records:
    """See `harness.cli.records.Records`."""

    def write(self, results: Results, folder: Path) -> None:
        """See `write_summary`."""
        write_summary(results, folder)

    def are_in(self, folder: Path) -> bool:
        """See `is_committed`."""
        return is_committed(folder)

    def text(self, folder: Path) -> str:
        """See `committed_text`."""
        return committed_text(folder)

    def table(self, folder: Path) -> RenderableType:
        """See `committed_table`."""
        return committed_table(folder)

    def refuse(self, folder: Path, flag: str) -> None:
        """See `refuse_committed`."""
        refuse_committed(folder, flag)
