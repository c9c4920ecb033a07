"""What ``harness transfer`` adds to an experiment: the folder ``transfer``, and a section of the report."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from harness.authoring.pages import render_page

from .record import TransferRecord, read_record_of

if TYPE_CHECKING:
    from rich.console import RenderableType

    from harness.results import Results

    from .matrix import Transfers

HERE = Path(__file__).parent


@dataclass(frozen=True)
class TransferSection:
    """A matrix of every algorithm and reward: trained in one simulator, evaluated in another."""

    what: ClassVar[str] = "an evaluation elsewhere"

    def ending(self, folder: Path) -> TransferRecord:
        return read_record_of(folder)

    def show(self, results: "Results") -> "_Shown | None":
        from .matrix import load_transfers

        transfers = load_transfers(results)
        return _Shown(transfers) if transfers.matrices else None


@dataclass(frozen=True)
class _Shown:
    transfers: "Transfers"

    @property
    def style(self) -> str:
        return (HERE / "transfer.css").read_text(encoding="utf-8").strip()

    def to_json(self) -> dict[str, Any]:
        return self.transfers.to_json()

    def table(self) -> "RenderableType":
        from .shown import transfer_table

        return transfer_table(self.transfers)

    def html(self) -> str:
        from .shown import EXPLANATION, TITLE, failure_lines, transfer_block

        page = render_page(
            HERE / "transfer.html.j2",
            "The HTML report",
            title=TITLE,
            explanation=EXPLANATION,
            blocks=[transfer_block(matrix) for matrix in self.transfers.matrices],
            failed=failure_lines(self.transfers.failed),
        )
        return page.strip()
